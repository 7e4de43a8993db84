"""The ship, what drives and steers her, how she moves, the canal she is in, and the file that says so."""
