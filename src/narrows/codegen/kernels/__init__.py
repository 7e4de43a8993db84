"""Loops and functions that the kernels of all models share, compiled once."""
