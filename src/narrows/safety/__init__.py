"""The safe envelope: how fast, and how far off the centreline, a ship stays controllable."""
