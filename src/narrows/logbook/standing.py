"""What this room's answers rest on, wherever they are shown."""

# The label of every page, result and report.
ON_TWINS = "Bank coefficients from legs and transits are shown on twins only, until a log is at hand."
