"""Texts that end a generated kernel: elementary functions, events, the queue of vessels."""
