"""Forecast a ship's motion near banks: with the rudder as it is, a pilot who takes over, and hard over either way."""
