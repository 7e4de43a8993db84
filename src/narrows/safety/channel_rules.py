"""Design rules of channels and canals, each with its source."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from narrows.errors import check_choice
from narrows.model.squat import choke_speed
from narrows.quantities.names import KNOT
from narrows.results import Tabulated
from narrows.ship.particulars import Configuration

# Kinds of bank in rules; a wall is steep.
BANKS = ("gentle", "sloping", "steep")
# Verification of the numbers of a rule.
READ, REMEMBERED = "checked in the source", "from memory, not checked"
KMH_PER_MS, FOOT = 3.6, 0.3048  # Kilometres per hour in one metre per second, and metres in one foot


@dataclass(frozen=True)
class ChannelRule:
    name: str  # Name in the table and the chart
    content: str  # The rule in words
    source: str  # Its source
    standing: str = READ  # Verification: which numbers were read in the source
    # Required widths, each with its range of speeds: lowest [knots], highest [knots], width [beams]
    widths: "Callable[[OutsideRules], list[tuple[float, float, float]]] | None" = None
    speed: "Callable[[OutsideRules], float] | None" = None  # Speed limit [m/s]; NaN for other ships
    rudder_deg: float | None = None  # Largest steady rudder [deg]


# Lowest and highest speed [knots], addition to the lane of 1.5 B for wind and speed [beams], clearance to a bank by its
# kind [beams].
PIANC_LANES = (
    (0.0, 8.0, 0.3, {"gentle": 0.0, "sloping": 0.3, "steep": 0.5}),
    (8.0, 12.0, 0.2, {"gentle": 0.1, "sloping": 0.5, "steep": 1.0}),
    (12.0, math.inf, 0.2, {"gentle": 0.2, "sloping": 0.7, "steep": 1.3}),
)


def pianc_widths(ship: "OutsideRules") -> list[tuple[float, float, float]]:
    """Return the required widths: a lane, wider by 0.2 B below h/T = 1.5 and by 0.4 B below 1.15, and clearances."""
    ratio = round(ship.depth / ship.draft, 2)
    lane = 1.5 + (0.4 if ratio < 1.15 else 0.2 if ratio < 1.5 else 0.0)
    return [(low, high, lane + added + 2 * clearance[ship.bank]) for low, high, added, clearance in PIANC_LANES]


def kiel_speed_limit(ship: "OutsideRules") -> float:
    """Return the speed limit [m/s] in the Kiel Canal; NaN for a ship that is too large for it."""
    if ship.length > 235.5 or ship.beam > 32.5:
        return math.nan
    return (12 if ship.draft > 8.5 else 15) / KMH_PER_MS


def panama_speed_limit(ship: "OutsideRules") -> float:
    """Return the speed limit of 1933 [m/s] in the Panama Canal, by width of the reach and, in the cut, length."""
    feet, reaches = (ship.wall_port + ship.wall_starboard) / FOOT, {1000: 15.0, 800: 12.0, 500: 10.0}
    cut = 6.0 if ship.length >= 250 * FOOT else 8.0
    return next((knots for width, knots in reaches.items() if feet >= width), cut) * KNOT


UFC_SOURCE = "UFC 4-150-06 (2001), Military harbors and coastal facilities, 5-6.2.2.1, ufgscriteria.tpub.com/4_150_06"
SUEZ_SOURCE = "Suez Canal Authority, Rules of navigation (2020), article 54, suezcanal.gov.eg"
# The rules, those of widths first.
CHANNEL_RULES = (
    ChannelRule(
        "PIANC 121",
        "a lane of 1.5 B for a ship of moderate manoeuvrability, with 0.3, 0.2 or 0.1 B for a mild wind (slow, "
        "moderate, fast), 0.1 B for a fast ship and 0.2 or 0.4 B for shallow water, and a clearance to either bank",
        "PIANC (2014), Report 121, Harbour approach channels: design guidelines, as in Kubla Ports' technical manual, "
        "kublasoftware.com/support/documentation/kubla-ports/2018/5.1/technical-manual/channel-widths/overview.html",
        "lane, wind and speed checked; clearance to the banks and the addition for shallow water from memory, not "
        "checked",
        pianc_widths,
    ),
    ChannelRule(
        "UFC 4-150-06",
        "to 10 knots in good conditions, a lane of 1.8 B for a ship that manoeuvres well, and 1.0 B to either bank, "
        "1.2 B where it is steeper than 1 on 3",
        UFC_SOURCE,
        widths=lambda ship: [(0.0, 10.0, 1.8 + 2 * (1.2 if ship.bank == "steep" else 1.0))],
    ),
    ChannelRule(
        "USACE EM 1110-2-1613",
        "2.5 to 3.0 B from bank to bank in a canal for one ship, here 3.0",
        "US Army Corps of Engineers, Engineer Manual 1110-2-1613, Hydraulic design of deep-draft navigation projects",
        REMEMBERED,
        lambda ship: [(0.0, math.inf, 3.0)],
    ),
    ChannelRule("UFC 4-150-06, rudder", "5 degrees of rudder at most, for long", UFC_SOURCE, rudder_deg=5.0),
    ChannelRule(
        "Suez, tanker or bulk carrier",
        "14 km/h for loaded tankers and bulk carriers of more than 44 ft, and for gas carriers",
        SUEZ_SOURCE,
        speed=lambda ship: 14 / KMH_PER_MS if ship.draft > 44 * FOOT else math.nan,
    ),
    ChannelRule("Suez, other ships", "16 km/h", SUEZ_SOURCE, speed=lambda ship: 16 / KMH_PER_MS),
    ChannelRule(
        "Kiel",
        "15 km/h; 12 for traffic group 6 or a draft of more than 8.5 m",
        "Wasserstrassen- und Schifffahrtsamt Nord-Ostsee-Kanal, wsa-kiel.wsv.de",
        speed=kiel_speed_limit,
    ),
    ChannelRule(
        "Panama, 1933",
        "15 knots where it is 1000 ft wide, 12 where 800, 10 where 500; in the cut 6, or 8 for a ship under 250 ft",
        "Executive Order 6128 (1933), presidency.ucsb.edu; its present rules were not found",
        speed=panama_speed_limit,
    ),
)


@dataclass(frozen=True, repr=False)
class OutsideRules(Tabulated):
    """Limits from outside rules for a ship in a section of water.

    Examples
    --------
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
        return "\n".join(map(_line, self.rows()))

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
        if rule.speed is not None:
            limit = rule.speed(self)
            return [] if math.isnan(limit) else [{"speed_limit": limit / KNOT, "of_choking": limit / self.choke}]
        limits: list[dict[str, Any]] = []
        for slowest, fastest, beams in rule.widths(self) if rule.widths else ():
            width = beams * self.beam
            port, starboard = width / 2 - self.wall_port, self.wall_starboard - width / 2
            offsets = {"port": port, "starboard": starboard} if port <= starboard else {}
            limits.append(
                {"slowest": slowest, "fastest": None if math.isinf(fastest) else fastest, "width": width, **offsets}
            )
        return limits or [{}]


def outside_rules(
    configuration: Configuration, bank: str = "steep", walls: tuple[float, float] | None = None
) -> OutsideRules:
    """Return the limits from design and canal rules for a ship in a section of water.

    No rule states a largest offset: it follows from the water that lane and required clearances leave.

    Parameters
    ----------
    configuration : Configuration
        Ship and canal.
    bank : str
        Kind of bank: ``gentle``, ``sloping`` or ``steep``; the walls of a canal are steep.
    walls : pair of float [m], optional
        Distances from the middle to where the keel meets the banks, port and starboard; default: the canal's walls.

    Raises
    ------
    InputError
        If there is no such kind of bank.

    Examples
    --------
    >>> rules = nw.outside_rules(kcs.configuration, bank="gentle")
    >>> len(rules.to_dataframe()) > 2
    True
    """
    check_choice("bank", bank, BANKS)
    ship, canal = configuration.ship, configuration.canal
    depth, choke = (math.nan, math.inf) if canal.depth is None else (canal.depth, choke_speed(configuration))
    return OutsideRules(
        ship.length, ship.beam, ship.draft, depth, bank, *(walls or (canal.width / 2, canal.width / 2)), choke
    )


def _line(row: dict[str, Any]) -> str:
    if row["speed_limit"] is not None:
        share = f", {100 * row['of_choking']:.0f} % of choking" if row["of_choking"] else ""
        return f"{row['rule']}: {row['speed_limit']:.2f} knots{share}."
    if row["rudder"] is not None:
        return f"{row['rule']}: {row['rudder']:g} degrees of rudder at most, for long."
    if row["starboard"] is None:
        return f"{row['rule']}{_speeds(row)}: none, it needs {row['width']:.0f} m of water."
    return f"{row['rule']}{_speeds(row)}: from {row['port']:+.0f} to {row['starboard']:+.0f} m off the middle."


def _speeds(row: dict[str, Any]) -> str:
    low, high = row["slowest"], row["fastest"]
    if high is None:
        return f", over {low:g} knots" if low else ""
    return f", {low:g} to {high:g} knots" if low else f", to {high:g} knots"
