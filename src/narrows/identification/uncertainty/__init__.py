"""How well coefficients are known: cluster-robust errors, intervals within bounds, resamples, profiles."""
