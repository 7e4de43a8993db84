"""Transits before they are sailed: their expected information, and twins with known truth."""
