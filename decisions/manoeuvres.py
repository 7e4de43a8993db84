"""KVLCC2's turning circles and zigzags beside the free-running tests of MARIN for SIMMAN 2008.

python decisions/manoeuvres.py [--write]

The measured figures were read from the raw records of the 7 m model (files MARIN_FREE_KVLCC2_tc_*, _zz_* as published
by github.com/martinlarsalbert/System-identification-of-Vessel-Manoeuvring-Models): distances from where the rudder
begins to move, overshoots over the nominal heading. Their rudder counts the other way round. The files of the circles
begin 0.10 (-35) and 0.16 (+35) ship lengths before the rudder moves, and the computed gear has no dead time.
"""

from pages import markdown, publish

import narrows as nw

APPROACH = 1.179
"""Of the 7 m model [m/s]."""
CIRCLES = {"+35": (3.09, 1.37, 3.34), "-35": (3.01, 1.23, 3.08)}
"""Measured advance, transfer and tactical diameter over the length."""
OVERSHOOTS = {"+10/10": (8.2, 21.9), "-10/10": (9.5, 15.0), "+20/20": (13.7, 14.9), "-20/20": (15.1, 13.3)}
"""Measured first and second overshoot [deg]."""


def text() -> str:
    """Circles, then zigzags: computed and measured."""
    found = nw.sail_trials(nw.published("yasukawa2015_kvlcc2"), APPROACH).to_dict()
    names = ("advance", "transfer", "tactical_diameter")
    circles, zigzags = [], []
    for order, measured in CIRCLES.items():
        own = [found["turning"][order][f"{name}_over_length"] for name in names]
        pairs = zip(own, measured, strict=True)
        circles.append(
            (f"{order} deg", *(f"{one:.2f}, {two:.2f} ({100 * (one / two - 1):+.0f} %)" for one, two in pairs))
        )
    for order, measured in OVERSHOOTS.items():
        pairs = zip(found["zigzags"][order]["overshoots_deg"], measured, strict=False)
        zigzags.append((order, *(f"{one:.1f}, {two:.1f}" for one, two in pairs)))
    heads = (f"{name.replace('_', ' ')}/L" for name in names)
    return "\n\n".join(
        (
            markdown(("rudder", *heads), circles),
            markdown(("zigzag", "first overshoot [deg]", "second [deg]"), zigzags),
        )
    )


if __name__ == "__main__":
    publish(__file__, "manoeuvres.md", text())
