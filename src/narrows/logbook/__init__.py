"""From a ship's own records to coefficients that its tests did not settle."""
