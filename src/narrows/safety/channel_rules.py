"""Design rules of channels and canals, each with its source (``channel_rules.toml``)."""

import math
import operator
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from narrows.base.errors import check_choice
from narrows.base.results import Tabulated
from narrows.model.water import choke_speed
from narrows.quantities.names import KNOT
from narrows.ship.particulars import Configuration

# Kinds of bank in rules; a wall is steep.
BANKS = ("gentle", "sloping", "steep")
# Verification of the numbers of a rule.
READ, REMEMBERED = "checked in the source", "from memory, not checked"
KMH_PER_MS = 3.6  # Kilometres per hour in one metre per second
# Limits in words, by the name of their column.
WORDS = {
    "slowest": "from {slowest:g} knots", "fastest": "to {fastest:g} knots", "width": "needs {width:.0f} m of water",
    "speed_limit": "{speed_limit:.2f} knots", "rudder": "{rudder:g} degrees of rudder at most, for long",
}  # fmt: skip
CONDITIONS = {"over": operator.gt, "least": operator.ge, "most": operator.le}


@dataclass(frozen=True)
class ChannelRule:
    name: str  # Name in the table and the chart
    content: str  # The rule in words
    source: str  # Its source
    standing: str = READ  # Verification: which numbers were read in the source
    widths: Sequence[Mapping[str, float]] = ()  # Required widths by ranges of speeds
    shallow: Sequence[tuple[float, float]] = ()  # Additions to the lane below a depth over draft [beams]
    speeds: Sequence[Mapping[str, Any]] = ()  # Speed limits with their conditions; none for other ships
    rudder_deg: float | None = None  # Largest steady rudder [deg]


_FILE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
CHANNEL_RULES = tuple(ChannelRule(**row) for row in _FILE["rule"])


@dataclass(frozen=True, repr=False)
class OutsideRules(Tabulated):
    """Limits from outside rules for a ship in a section of water.

    >>> nw.outside_rules(kcs.configuration).to_dataframe().empty
    False
    """

    length: float  #: Length of the ship [m]
    beam: float  #: Its beam [m]
    draft: float  #: Its draft [m]
    depth: float  #: Depth of the water; NaN if unknown [m]
    bank: str  #: Kind of bank: gentle, sloping or steep
    wall_port: float  #: Distance from the middle to where the keel meets the bank [m]
    wall_starboard: float  #: The same to starboard [m]
    choke: float  #: Speed at which the canal is choked; infinite if the depth is unknown [m/s]

    def summary(self) -> str:
        return "\n".join(map(_sentence, self.rows()))

    @property
    def notes(self) -> tuple[str, ...]:
        """The rules, and which of their numbers were not read in the source."""
        return (
            f"banks taken as {self.bank}",
            "a rule of widths is for one ship in good weather, without cross current; passing and bends need more",
            "a speed limit is that of its own canal, for its banks, traffic and convoys, and is shown for comparison",
            *(f"{rule.name}: {rule.standing}" for rule in CHANNEL_RULES if rule.standing != READ),
        )

    def rows(self) -> list[dict[str, Any]]:
        """Return one row per rule and range of speeds: offsets [m], required width [m], speeds [knots], rudder [deg].

        Offsets are None if the rule requires more water than there is, and for other rules than those of widths.
        """
        return [
            dict.fromkeys(("rule", "slowest", "fastest", "width", "port", "starboard", "speed_limit", "of_choking"))
            | {"rudder": rule.rudder_deg} | limits
            | {"rule": rule.name, "content": rule.content, "standing": rule.standing, "source": rule.source}
            for rule in CHANNEL_RULES for limits in self._limits(rule)
        ]  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        return {"summary": self.summary(), "bank": self.bank, "rules": self.rows(), "notes": list(self.notes)}

    def _limits(self, rule: ChannelRule) -> list[dict[str, Any]]:
        known = {**vars(self), "width": self.wall_port + self.wall_starboard}
        for row in rule.speeds:
            tests = ((holds, *one) for name, holds in CONDITIONS.items() for one in row.get(name, {}).items())
            if all(holds(known[quantity], bound) for holds, quantity, bound in tests):
                limit = row["knots"] * KNOT if "knots" in row else row["kmh"] / KMH_PER_MS
                return [{"speed_limit": limit / KNOT, "of_choking": limit / self.choke}]
        ratio, limits = round(self.depth / self.draft, 2), list[dict[str, Any]]()
        added = next((more for below, more in rule.shallow if ratio < below), 0.0)
        for row in rule.widths:
            width = (row["lane"] + added + 2 * row[self.bank]) * self.beam
            port, starboard = width / 2 - self.wall_port, self.wall_starboard - width / 2
            offsets = {"port": port, "starboard": starboard} if port <= starboard else {}
            ends = {"slowest": row.get("slowest", 0.0), "fastest": row.get("fastest")}
            limits.append({**ends, "width": width, **offsets})
        return limits or [{}] * (not rule.speeds)


def outside_rules(
    configuration: Configuration, bank: str = "steep", walls: tuple[float, float] | None = None
) -> OutsideRules:
    """Return the limits from design and canal rules for a ship in a section of water.

    No rule states a largest offset: it follows from the water that lane and required clearances leave.

    Raises an InputError if there is no such kind of bank.

    Parameters
    ----------
    configuration, bank : Configuration, str
        Ship and canal; kind of bank, ``gentle``, ``sloping`` or ``steep``, as the walls of a canal are.
    walls : pair of float [m], optional
        Distances from the middle to where the keel meets the banks, port and starboard; default: the canal's walls.

    Examples
    --------
    >>> rules = nw.outside_rules(kcs.configuration, bank="gentle")
    >>> len(rules.to_dataframe()) > 2
    True
    """
    check_choice("bank", bank, BANKS)
    ship, canal = configuration.ship, configuration.canal
    depth, choke = (math.nan, math.inf) if canal.depth is None else (canal.depth, choke_speed(configuration))
    port, starboard = walls or (canal.width / 2, canal.width / 2)
    return OutsideRules(ship.length, ship.beam, ship.draft, depth, bank, port, starboard, choke)


def _sentence(row: dict[str, Any]) -> str:
    words = [form.format(**row) for name, form in WORDS.items() if row[name]]
    if row["width"]:
        fits = row["port"] is not None
        words.append("offsets from {port:+.0f} to {starboard:+.0f} m".format(**row) if fits else "more than there is")
    if row["of_choking"]:
        words.append(f"{100 * row['of_choking']:.0f} % of choking")
    return f"{row['rule']}: {', '.join(words)}."
