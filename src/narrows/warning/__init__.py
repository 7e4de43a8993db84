"""Warning: from the ship's own sentences to what a bank will do to it, and to alerts; decision support."""
