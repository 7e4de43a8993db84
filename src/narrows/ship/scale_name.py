"""The scale in a ship's name, as in ``KCS 1:52.667``: true at every size that the ship is brought to."""

import re

SCALE = re.compile(r"\b1:(?P<smaller>\d+(\.\d+)?)\b|\b(?P<larger>\d+(\.\d+)?):1\b|\bat full scale\b")
# Within which of 1 a scale is full.
EQUAL = 5e-3


def name_at_scale(name: str, ratio: float) -> str:
    """Return a ship's name after its lengths were multiplied; a name without a scale stays what it is."""
    return SCALE.sub(lambda known: _in_words(_scale(known) / ratio), name)


def _scale(known: re.Match[str]) -> float:
    """How many times smaller than the ship."""
    return float(known["smaller"] or 1.0) / float(known["larger"] or 1.0)


def _in_words(scale: float) -> str:
    if abs(scale - 1) < EQUAL:
        return "at full scale"
    return f"1:{scale:.5g}" if scale > 1 else f"{1 / scale:.4g}:1"
