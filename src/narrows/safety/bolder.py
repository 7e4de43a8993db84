"""Where an answer of ours is bolder than a rule from outside, and why."""

from typing import Any

import numpy as np
import xarray as xr

from narrows.quantities.constants import KNOT
from narrows.safety.channel_rules import READ
from narrows.safety.outside_rules import OutsideRules

WHY_WIDER = (
    "those widths have room for a hand at the wheel, for wind and for current; the pilot of these trials knows offset, "
    "heading and drift exactly, and feels no more than the weather above"
)
WHY_RUDDER = "here the steady rudder is to leave a reserve for the unforeseen, which is tried, and not to stay small"
WHY_FASTER = "those limits guard banks and traffic too, which is not asked here"


def bolder_than(data: xr.Dataset, rules: OutsideRules, share: float) -> tuple[str, ...]:
    """Say where the model has a ship safe beyond what a rule allows, and why, a sentence each."""
    data = data.transpose("y", "u", ...)
    safe = ((data["held"] >= share) & data["clear"]).to_numpy()
    if not safe.any():
        return ()
    rows = rules.rows()
    return tuple(filter(None, (_wider(data, safe, rows), _harder(data, safe, rows), _faster(data, safe, rows))))


def _wider(data: xr.Dataset, safe: np.ndarray, rows: list[dict[str, Any]]) -> str:
    """The rules of widths beyond which a place is safe, each at the speeds where it is most so."""
    y, knots = data["y"].to_numpy(), data["u"].to_numpy() / KNOT
    worst: dict[str, tuple[float, str]] = {}
    for row in rows:
        if row["width"] is None:
            continue
        asked = (knots >= row["slowest"]) & (knots <= (row["fastest"] or np.inf))
        far = y[safe[:, asked].any(axis=1)]
        fits = row["starboard"] is not None
        limits = (row["port"], row["starboard"]) if fits else (0.0, 0.0)
        over = max((limits[0] - far.min(), far.max() - limits[1])) if far.size else -1.0
        if far.size and (over > 0 or not fits):
            place = float(far[np.abs(far).argmax()])
            allowed = f"{limits[1] if place > 0 else limits[0]:+.0f} m" if fits else "nowhere"
            doubt = "" if row["standing"] == READ else ", in part from memory"
            words = f"{row['rule']} ({allowed} instead of {place:+.0f} m{doubt})"
            worst[row["rule"]] = max(worst.get(row["rule"], (-np.inf, "")), (over, words))
    listed = " and ".join(words for _, words in worst.values())
    return f"Bolder than {listed}: {WHY_WIDER}." if worst else ""


def _harder(data: xr.Dataset, safe: np.ndarray, rows: list[dict[str, Any]]) -> str:
    """The rule of rudders, where more is kept on in half of the cases."""
    most = float(np.degrees(np.abs(data["rudder"].to_numpy()[safe]).max()))
    rules = [row for row in rows if row["rudder"] is not None and most > row["rudder"]]
    listed = " and ".join(f"{row['rule']} ({row['rudder']:g} instead of {most:.0f} degrees)" for row in rules)
    return f"Bolder than {listed}: {WHY_RUDDER}." if rules else ""


def _faster(data: xr.Dataset, safe: np.ndarray, rows: list[dict[str, Any]]) -> str:
    """The speed limits over which a speed is safe."""
    fastest = float(data["u"].to_numpy()[safe.any(axis=0)].max()) / KNOT
    over = [row for row in rows if row["speed_limit"] is not None and fastest > row["speed_limit"]]
    listed = ", ".join(f"{row['rule']} ({row['speed_limit']:.1f} knots)" for row in over)
    return f"By the model safe to {fastest:.1f} knots, over the limits of {listed}: {WHY_FASTER}." if over else ""
