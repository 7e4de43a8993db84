"""Transits before they are sailed: what they will tell, and twins of them whose truth is known."""
