"""Faults of a ship's own records, before anything is fitted to them."""
