"""A model, its file, and its transfer to another size, depth or rudder."""
