"""Simulation: one voyage in the time of a key press, a million in seconds, each to a grounding or another end."""

from narrows.lazy import names_of_stub

__getattr__, __dir__, __all__ = names_of_stub(__name__, __file__)
