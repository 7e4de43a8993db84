"""What pages in a browser share: the drawing of a canal, and the palettes."""
