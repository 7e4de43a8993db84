"""Identification: rows to sums of products, sums to coefficients and to how far they can be trusted."""
