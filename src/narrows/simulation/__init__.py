"""Simulation: one voyage in the time of a key press, a million in seconds, each to a grounding or another end."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
