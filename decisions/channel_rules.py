"""Rules of designers and canals, and what they leave three ships: the tables of docs/safe-envelope.md.

python decisions/channel_rules.py [--write]
"""

from typing import Any

from pages import markdown, publish

import narrows as nw
from narrows.safety.channel_rules import BANKS, CHANNEL_RULES

CASES = {
    "400 m, 58.8 m wide, in 205 x 24 m": nw.Configuration(nw.Ship(399.94, 58.8, 15.85, 0.661), nw.Canal(205.0, 24.0)),
    "KVLCC2, 320 m, in 400 x 30 m": nw.Configuration(nw.Ship(320.0, 58.0, 20.8, 0.81), nw.Canal(400.0, 30.0)),
    "KCS, 230 m, in 300 x 16.2 m": nw.Configuration(nw.Ship(230.0, 32.2, 10.8, 0.65), nw.Canal(300.0, 16.2)),
}


def sources() -> str:
    """Each rule and its content."""
    return markdown(("rule", "content"), [(rule.name, rule.content) for rule in CHANNEL_RULES])


def cases() -> str:
    """What each rule leaves each ship, at gentle, sloping and steep banks."""
    by_case = [[nw.outside_rules(case, bank).rows() for bank in BANKS] for case in CASES.values()]
    keys = dict.fromkeys(key(row) for banks in by_case for row in banks[0] if row["rudder"] is None)
    rows = [(named(*wanted), *(cell(banks, wanted) for banks in by_case)) for wanted in keys]
    return markdown(("rule", *CASES), rows)


def key(row: dict[str, Any]) -> tuple[str, float | None, float | None]:
    """The rule and the speeds between which it holds [knots]."""
    return row["rule"], row["slowest"], row["fastest"]


def named(rule: str, low: float | None, high: float | None) -> str:
    """A rule and its speeds in words."""
    if not low and not high:
        return rule
    return f"{rule}, over {low:g} knots" if high is None else f"{rule}, {low:g} to {high:g} knots"


def cell(banks: list[list[dict[str, Any]]], wanted: tuple[str, float | None, float | None]) -> str:
    """Offsets [m] at the three kinds of bank, once where they are one; or a speed [knots] and its share of choking."""
    found = [row for rows in banks for row in rows if key(row) == wanted]
    if not found:
        return "-"
    if found[0]["speed_limit"] is not None:
        return f"{found[0]['speed_limit']:.2f} knots, {100 * found[0]['of_choking']:.0f} %"
    offsets = ["none" if row["starboard"] is None else f"{row['starboard']:.0f}" for row in found]
    return " / ".join(offsets if len(set(offsets)) > 1 else offsets[:1])


def text() -> str:
    """Two tables."""
    left = "Offset that each leaves [m], at gentle / sloping / steep banks, or its speed limit as a share of choking:"
    return f"{sources()}\n\n{left}\n\n{cases()}"


if __name__ == "__main__":
    publish(__file__, "safe-envelope.md", text())
