"""Design rules of channels and canals, each with its source."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any

from narrows.errors import check_choice
from narrows.model.squat import choke_speed
from narrows.quantities.names import KNOT
from narrows.results import BaseResult
from narrows.ship.particulars import Configuration

if TYPE_CHECKING:
    import pandas as pd

# Kinds of bank in rules; a wall is steep.
BANKS = ("gentle", "sloping", "steep")
# Reliability of the numbers of a rule.
READ, REMEMBERED = "checked in the source", "from memory, not checked"
# Kilometres per hour in one metre per second, and metres in one foot.
HOUR, FOOT = 3.6, 0.3048


@dataclass(frozen=True)
class Passage:
    length: float  # Length of the ship [m]
    beam: float  # Beam of the ship [m]
    draft: float  # Draft of the ship [m]
    width: float  # Width from bank to bank, where the keel meets them [m]
    depth: float | None  # Depth of the water; None if unknown [m]
    bank: str  # Gentle, sloping or steep


@dataclass(frozen=True)
class Lane:
    """Required channel width of a rule [beams], over a range of speeds."""

    slowest: float  # Lowest speed of the rule [knots]
    fastest: float  # Highest speed of the rule [knots]
    lane: float  # Width of the manoeuvring lane [1]
    clearance: Mapping[str, float]  # Clearance from the lane to either bank, by its kind [1]


def shallow_lane(passage: Passage) -> float:
    """Return the additional lane width in shallow water [1]: 0.2 B below h/T = 1.5, 0.4 B below 1.15."""
    ratio = math.inf if passage.depth is None else round(passage.depth / passage.draft, 2)
    return 0.4 if ratio < 1.15 else 0.2 if ratio < 1.5 else 0.0


@dataclass(frozen=True)
class ChannelRule:
    name: str  # Name in the table and the chart
    criterion: str
    content: str  # The rule in words
    source: str  # Its source
    standing: str = READ  # Verification: which numbers were read in the source
    lanes: tuple[Lane, ...] = ()  # Required widths, for a rule of widths
    deepens: Callable[[Passage], float] = lambda passage: 0.0  # Additional beams of a lane, by the passage
    speed: Callable[[Passage], float] | None = None  # [m/s] limit; NaN for other ships
    rudder_deg: float | None = field(default=None)  # Largest steady rudder, for a rule of rudders [deg]


def kiel(passage: Passage) -> float:
    """Return the speed limit [m/s] in the Kiel Canal; NaN for a ship that is too large for it."""
    if passage.length > 235.5 or passage.beam > 32.5:
        return math.nan
    return (12 if passage.draft > 8.5 else 15) / HOUR


def panama(passage: Passage) -> float:
    """Return the speed limit of 1933 [m/s] in the Panama Canal, by width of the reach and, in the cut, length."""
    reaches = {1000: 15.0, 800: 12.0, 500: 10.0}
    cut = 6.0 if passage.length >= 250 * FOOT else 8.0
    return next((knots for feet, knots in reaches.items() if passage.width >= feet * FOOT), cut) * KNOT


# Clearance from a lane to a bank [beams], at under 8, 8 to 12 and over 12 knots.
PIANC_CLEARANCE = {"gentle": (0.0, 0.1, 0.2), "sloping": (0.3, 0.5, 0.7), "steep": (0.5, 1.0, 1.3)}

PIANC = ChannelRule(
    "PIANC 121",
    "beam, speed, depth over draft, kind of bank",
    "a lane of 1.5 B for a ship of moderate manoeuvrability, with 0.3, 0.2 or 0.1 B for a mild wind (slow, moderate, "
    "fast), 0.1 B for a fast ship and 0.2 or 0.4 B for shallow water, and a clearance to either bank",
    "PIANC (2014), Report 121, Harbour approach channels: design guidelines, as Kubla Ports' technical manual has it, "
    "kublasoftware.com/support/documentation/kubla-ports/2018/5.1/technical-manual/channel-widths/overview.html",
    "lane, wind and speed checked; clearance to the banks and the addition for shallow water from memory, not checked",
    tuple(
        Lane(low, high, 1.5 + wind + fast, {bank: by_speed[place] for bank, by_speed in PIANC_CLEARANCE.items()})
        for place, (low, high, wind, fast) in enumerate(
            ((0.0, 8.0, 0.3, 0.0), (8.0, 12.0, 0.2, 0.0), (12.0, math.inf, 0.1, 0.1))
        )
    ),
    shallow_lane,
)

UFC_SOURCE = "UFC 4-150-06 (2001), Military harbors and coastal facilities, 5-6.2.2.1, ufgscriteria.tpub.com/4_150_06"

# The rules, those of widths first.
CHANNEL_RULES = (
    PIANC,
    ChannelRule(
        "UFC 4-150-06",
        "beam, slope of the bank",
        "to 10 knots in good conditions, a lane of 1.8 B for a ship that manoeuvres well, and 1.0 B to either bank, "
        "1.2 B where it is steeper than 1 on 3",
        UFC_SOURCE,
        lanes=(Lane(0.0, 10.0, 1.8, {"gentle": 1.0, "sloping": 1.0, "steep": 1.2}),),
    ),
    ChannelRule(
        "USACE EM 1110-2-1613",
        "beam",
        "2.5 to 3.0 B from bank to bank in a canal for one ship, here 3.0",
        "US Army Corps of Engineers, Engineer Manual 1110-2-1613, Hydraulic design of deep-draft navigation projects",
        REMEMBERED,
        (Lane(0.0, math.inf, 3.0, dict.fromkeys(BANKS, 0.0)),),
    ),
    ChannelRule(
        "UFC 4-150-06, rudder",
        "the rudder that holds the ship",
        "5 degrees of rudder at most, for long",
        UFC_SOURCE,
        rudder_deg=5.0,
    ),
    ChannelRule(
        "Suez, tanker or bulk carrier",
        "cargo, draft",
        "14 km/h for loaded tankers and bulk carriers of more than 44 ft, and for gas carriers",
        "Suez Canal Authority, Rules of navigation (2020), article 54, suezcanal.gov.eg",
        speed=lambda passage: 14 / HOUR if passage.draft > 44 * FOOT else math.nan,
    ),
    ChannelRule(
        "Suez, other ships",
        "cargo, draft",
        "16 km/h",
        "Suez Canal Authority, Rules of navigation (2020), article 54, suezcanal.gov.eg",
        speed=lambda passage: 16 / HOUR,
    ),
    ChannelRule(
        "Kiel",
        "draft, traffic group",
        "15 km/h; 12 for traffic group 6 or a draft of more than 8.5 m",
        "Wasserstrassen- und Schifffahrtsamt Nord-Ostsee-Kanal, wsa-kiel.wsv.de",
        speed=kiel,
    ),
    ChannelRule(
        "Panama, 1933",
        "width of the reach, length",
        "15 knots where it is 1000 ft wide, 12 where 800, 10 where 500; in the cut 6, or 8 for a ship under 250 ft",
        "Executive Order 6128 (1933), presidency.ucsb.edu; its present rules were not found",
        speed=panama,
    ),
)

# Limits from rules of designers and canals for a ship in a section of water, for comparison.
OF_OTHER_WATERS = (
    "a speed limit is that of its own canal, for its banks, traffic and convoys, and is shown for comparison"
)

NOT_ASKED = "a rule of widths is for one ship in good weather, without cross current; passing and bends need more"


@dataclass(frozen=True, repr=False)
class OutsideRules(BaseResult):
    """Limits from outside rules for a ship in a section of water.

    Parameters
    ----------
    passage : Passage
        Ship and section.
    port, starboard : float [m]
        Places where its keel meets the banks, from the middle.
    choke : float [m/s]
        Speed at which the canal is choked; infinite if the depth is unknown.

    Examples
    --------
    >>> nw.outside_rules(kcs.configuration).to_dataframe().empty
    False
    """

    passage: Passage
    port: float
    starboard: float
    choke: float

    def summary(self) -> str:
        """Return the limits of each rule, one line each."""
        return "\n".join(_line(row) for row in self.rows())

    @property
    def notes(self) -> tuple[str, ...]:
        """The rules, and which of their numbers were not read in the source."""
        doubts = [f"{rule.name}: {rule.standing}" for rule in CHANNEL_RULES if rule.standing != READ]
        return (f"banks taken as {self.passage.bank}", NOT_ASKED, OF_OTHER_WATERS, *doubts)

    def rows(self) -> list[dict[str, Any]]:
        """Return one row per rule and range of speeds: offsets [m], required width [m], speeds [knots], rudder [deg].

        Offsets are None if the rule requires more water than there is, and for other rules than those of widths.
        """
        return [row for rule in CHANNEL_RULES for row in self._rows(rule)]

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name."""
        return {"summary": self.summary(), "bank": self.passage.bank, "rules": self.rows(), "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the rows as a table."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def attributes(self) -> dict[str, float | str]:
        """Return the inputs as attributes of a dataset, for ``rules_of``."""
        deep = math.nan if self.passage.depth is None else self.passage.depth
        return {**asdict(self.passage), "depth": deep, "wall_port": self.port, "wall_starboard": self.starboard,
                "choke": self.choke}  # fmt: skip

    def _rows(self, rule: ChannelRule) -> Iterable[dict[str, Any]]:
        row = {
            "rule": rule.name, "slowest": None, "fastest": None, "width": None, "port": None, "starboard": None,
            "speed_limit": None, "of_choking": None, "rudder": rule.rudder_deg, "content": rule.content,
            "standing": rule.standing, "source": rule.source,
        }  # fmt: skip
        if rule.speed is not None:
            limit = rule.speed(self.passage)
            if not math.isnan(limit):
                yield {**row, "speed_limit": limit / KNOT, "of_choking": limit / self.choke}
        elif rule.lanes:
            for lane in rule.lanes:
                yield {**row, **self._left(rule, lane)}
        else:
            yield row

    def _left(self, rule: ChannelRule, lane: Lane) -> dict[str, float | None]:
        passage = self.passage
        width = passage.beam * (lane.lane + rule.deepens(passage) + 2 * lane.clearance[passage.bank])
        port, starboard = width / 2 - self.port, self.starboard - width / 2
        fits = port <= starboard
        fastest = None if math.isinf(lane.fastest) else lane.fastest
        return {
            "slowest": lane.slowest, "fastest": fastest, "width": width, "port": port if fits else None,
            "starboard": starboard if fits else None,
        }  # fmt: skip


def outside_rules(
    configuration: Configuration, bank: str = "steep", walls: tuple[float, float] | None = None
) -> OutsideRules:
    """Return the limits from design and canal rules for a ship in a section of water.

    Rules do not contain the largest offset: it is the water left by the lane and the required clearance to either bank.
    The rules and their sources are in ``CHANNEL_RULES``.

    Parameters
    ----------
    configuration : Configuration
        Ship and canal.
    bank : str
        Kind of bank: ``gentle``, ``sloping`` or ``steep``; the walls of a canal are steep.
    walls : pair of float [m], optional
        Places where the keel meets the banks, to port and to starboard of the middle; default: the canal's walls.

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
    port, starboard = walls or (canal.width / 2, canal.width / 2)
    passage = Passage(ship.length, ship.beam, ship.draft, port + starboard, canal.depth, bank)
    return OutsideRules(passage, port, starboard, math.inf if canal.depth is None else choke_speed(configuration))


def rules_of(attributes: Mapping[str, Any]) -> OutsideRules:
    known = {entry.name: attributes[entry.name] for entry in fields(Passage)}
    passage = Passage(**{**known, "depth": None if math.isnan(known["depth"]) else known["depth"]})
    return OutsideRules(passage, attributes["wall_port"], attributes["wall_starboard"], attributes["choke"])


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
