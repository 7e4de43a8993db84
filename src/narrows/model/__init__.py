"""A model as one table of terms with its coefficients; its file, and its transfer to another size, depth or rudder."""
