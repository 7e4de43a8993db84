"""What this room's answers rest on, wherever they are shown."""

ON_TWINS = "Bank coefficients from legs and transits are shown on twins only, until a log is at hand."
"""The label of every page, result and report."""
