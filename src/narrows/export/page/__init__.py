"""A model as one page: it sails fleets of itself in a browser."""
