"""Texts appended to a generated kernel: elementary functions, events, the queue of vessels."""
