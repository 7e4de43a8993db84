"""Learn coefficients from records of a free ship: prior, search, answer."""
