"""Names, units, dimensions and constants: the vocabulary of everything else."""
