"""What records of a free ship teach of its coefficients: prior, search, answer."""
