"""Reproductions of published cases, with the printed numbers."""
