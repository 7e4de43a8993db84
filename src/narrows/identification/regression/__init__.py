"""Rows to normal equations, and these to coefficients within their bounds: exact, one by one and in batches."""
