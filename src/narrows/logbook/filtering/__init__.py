"""A Kalman filter of records: its likelihood, scores and smoothed paths."""
