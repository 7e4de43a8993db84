"""A model as one page that simulates fleets."""
