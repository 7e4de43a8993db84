"""The ship, what drives and steers it, how it moves, the canal it is in, and the file that says so."""
