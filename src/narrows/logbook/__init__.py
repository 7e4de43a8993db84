"""System identification: learn coefficients that the tests did not settle, from a ship's own records."""
