"""Forecast a ship's motion near banks: with the rudder unchanged, an escape, and hard over either way."""
