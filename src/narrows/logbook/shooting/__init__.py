"""The fit of a model to a ship's own records by multiple shooting: windows, their slopes, the equations, the search."""
