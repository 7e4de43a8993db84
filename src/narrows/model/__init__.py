"""A model and its file, and what becomes of it at another size, depth or rudder."""
