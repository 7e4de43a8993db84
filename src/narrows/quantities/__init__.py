"""Names, units, dimensions and constants: the shared vocabulary."""
