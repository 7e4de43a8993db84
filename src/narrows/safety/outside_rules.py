"""What the rules of designers and canals leave a ship in a section of water, to stand beside an answer of our own."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

from narrows.errors import check_choice
from narrows.model.squat import choke_speed
from narrows.quantities.constants import KNOT
from narrows.results import Shown
from narrows.safety.channel_rules import BANKS, CHANNEL_RULES, READ, ChannelRule, Lane, Passage, asked_width
from narrows.ship.particulars import Configuration

if TYPE_CHECKING:
    import pandas as pd

OF_OTHER_WATERS = (
    "a speed limit is that of its canal, for all that is at stake there (banks, traffic, convoys), and is shown for "
    "comparison"
)
NOT_ASKED = "a rule of widths has room for one ship in good weather, without cross current; passing and bends ask more"


@dataclass(frozen=True, repr=False)
class OutsideRules(Shown):
    """What rules from outside leave a ship in a section of water.

    Parameters
    ----------
    passage : Passage
        Ship and section.
    port, starboard : float [m]
        Where its keel meets the banks, from the middle.
    choke : float [m/s]
        Speed at which the canal is choked; infinite where the depth is not known.
    """

    passage: Passage
    port: float
    starboard: float
    choke: float

    def summary(self) -> str:
        """Say what each rule leaves, a line for each."""
        return "\n".join(_line(row) for row in self.rows())

    @property
    def notes(self) -> tuple[str, ...]:
        """What the rules are, and which of their numbers were not read."""
        doubts = [f"{rule.name}: {rule.standing}" for rule in CHANNEL_RULES if rule.standing != READ]
        return (f"banks taken as {self.passage.bank}", NOT_ASKED, OF_OTHER_WATERS, *doubts)

    def rows(self) -> list[dict[str, Any]]:
        """Give a row a rule, and a range of speeds: offsets [m], width asked for [m], speeds [knots], rudder [deg].

        Offsets are None where the rule asks for more water than there is, and where it is none of widths.
        """
        return [row for rule in CHANNEL_RULES for row in self._rows(rule)]

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name."""
        return {"summary": self.summary(), "bank": self.passage.bank, "rules": self.rows(), "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the rows as a table."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def attributes(self) -> dict[str, float | str]:
        """Give what it was made from as attributes of a dataset, for ``rules_of``."""
        deep = math.nan if self.passage.depth is None else self.passage.depth
        return {**asdict(self.passage), "depth": deep, "wall_port": self.port, "wall_starboard": self.starboard,
                "choke": self.choke}  # fmt: skip

    def _rows(self, rule: ChannelRule) -> Iterable[dict[str, Any]]:
        row = {
            "rule": rule.name, "slowest": None, "fastest": None, "width": None, "port": None, "starboard": None,
            "speed_limit": None, "of_choking": None, "rudder": rule.rudder_deg, "says": rule.says,
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
        width = asked_width(rule, lane, self.passage)
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
    """Say what rules of designers and canals leave a ship in a section of water.

    How far off the middle a rule lets a ship go is not in the rules: it is what is left of the water beside the lane
    and the clearance to either bank that they ask for. The rules and their sources are in ``CHANNEL_RULES``.

    Parameters
    ----------
    configuration : Configuration
        Ship and canal.
    bank : str
        Kind of bank: ``gentle``, ``sloping`` or ``steep``; the walls of a canal are steep.
    walls : pair of float [m], optional
        Where the keel meets the banks, to port and to starboard of the middle; the walls of the canal unless given.

    Raises
    ------
    InputError
        Where there is no such kind of bank.
    """
    check_choice("bank", bank, BANKS)
    ship, canal = configuration.ship, configuration.canal
    port, starboard = walls or (canal.width / 2, canal.width / 2)
    passage = Passage(ship.length, ship.beam, ship.draft, port + starboard, canal.depth, bank)
    return OutsideRules(passage, port, starboard, math.inf if canal.depth is None else choke_speed(configuration))


def rules_of(attributes: Mapping[str, Any]) -> OutsideRules:
    """Return the rules again from the attributes of a dataset."""
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
        return f"{row['rule']}{_speeds(row)}: none, it asks for {row['width']:.0f} m of water."
    return f"{row['rule']}{_speeds(row)}: from {row['port']:+.0f} to {row['starboard']:+.0f} m off the middle."


def _speeds(row: dict[str, Any]) -> str:
    low, high = row["slowest"], row["fastest"]
    if high is None:
        return f", over {low:g} knots" if low else ""
    return f", {low:g} to {high:g} knots" if low else f", to {high:g} knots"
