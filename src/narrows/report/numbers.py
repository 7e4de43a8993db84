"""Numbers as people read them: as many digits as their uncertainty leaves."""

import math


def readable(value: float, std: float = math.nan) -> str:
    """Write a number to the second digit of its standard error, or to four digits."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else ("inf" if value > 0 else "-inf")
    if not (math.isfinite(std) and std > 0):
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(std)))
    return f"{round(value, digits):.{min(digits, 8)}f}"


def interval(ends: tuple[float, float], std: float) -> str:
    """Write an interval."""
    return f"{readable(ends[0], std)} to {readable(ends[1], std)}"
