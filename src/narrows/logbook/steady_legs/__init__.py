"""Legs held steadily to one side and the other: readings, balance, what they teach, which ones to hold."""
