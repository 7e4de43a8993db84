"""Printers of lines: Python for floats and columns, loops over lanes for Numba."""
