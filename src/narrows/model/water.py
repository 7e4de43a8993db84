"""Water around a moving ship: squat by formulas, sinkage, the speed that chokes the section; mass and added mass."""

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_choice, shown
from narrows.base.results import BaseResult
from narrows.physics import squat_and_depth as formulas
from narrows.physics.squat_and_depth import BOUNDLESS
from narrows.quantities.arithmetic import choice, maximum, minimum
from narrows.quantities.names import Number, evaluate
from narrows.ship.checks import is_finite
from narrows.ship.particulars import Configuration, Configured, Ship

if TYPE_CHECKING:
    import pandas as pd

Sinkage = Literal["midship", "bow", "largest"]
GIVES = get_args(Sinkage)
VERIFIED, UNVERIFIED = "read in a source", "from memory, not verified"


@dataclass(frozen=True)
class SquatFormula:
    """A squat formula.

    >>> nw.SQUAT["huuska"].gives
    'bow'
    """

    function: Callable[..., Number]  #: Function; its arguments are names of the vocabulary
    gives: str  #: Kind of sinkage: ``midship``, ``bow``, ``largest`` or ``mean``
    status: str  #: Reliability of the formula
    #: Range of validity [1]: depth Froude number ``froude``, ``blockage``, ``depth_to_draft``, ``block_coefficient``
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def source(self) -> str:
        """Its source."""
        text = inspect.cleandoc(self.function.__doc__ or "").partition("Source:")[2]
        return " ".join(text.partition("\n\n")[0].split()).rstrip(".")


SUBCRITICAL = {"froude": (0.0, 0.7)}
# The formulas by name, the preferred first.
SQUAT = {
    "huuska": SquatFormula(formulas.huuska, "bow", VERIFIED, {**SUBCRITICAL, "block_coefficient": (0.6, 0.8)}),
    "icorels": SquatFormula(formulas.icorels, "bow", VERIFIED, {**SUBCRITICAL, "blockage": (0.0, 0.03)}),
    "barrass": SquatFormula(
        formulas.barrass, "largest", VERIFIED, {"blockage": (0.10, 0.25), "depth_to_draft": (1.1, 1.4)}
    ),
    "tuck_midship": SquatFormula(formulas.tuck_midship, "midship", UNVERIFIED, SUBCRITICAL),
    "tuck_bow": SquatFormula(formulas.tuck_bow, "bow", UNVERIFIED, SUBCRITICAL),
    "continuity": SquatFormula(formulas.continuity, "mean", "derived from its equations"),
}


@dataclass(frozen=True, repr=False)
class Squat(BaseResult):
    """A sinkage and its formula."""

    sinkage: Number  #: Sinkage [m]; an array for several speeds
    formula: str  #: Its name in ``SQUAT``
    gives: str  #: Kind of sinkage
    critical_speed: float  #: Speed at which the canal chokes [m/s]
    notes: tuple[str, ...]  #: Uses outside the formula's range, or an unverified formula
    #: Ship and speed [m/s], for the sinkage of other places: ``bow``, ``midship``, ``largest``
    of: tuple[Configuration, Number] | None = field(default=None, compare=False)

    def to_dataframe(self) -> "pd.DataFrame":
        """Return it as a table, one row for each speed, by the formula's name."""
        import pandas as pd

        rows = {"gives": self.gives, "sinkage": np.ravel(self.sinkage), "critical_speed": self.critical_speed}
        rows |= {"u": np.ravel(self.of[1])} if self.of else {}
        return pd.DataFrame(rows, pd.Index([self.formula] * np.size(self.sinkage), name="formula"))

    def summary(self) -> str:
        ends = dict.fromkeys(f"{end(self.sinkage):.3g}" for end in (np.min, np.max))
        return (
            f"The {self.gives} sinkage is {' to '.join(ends)} m by {self.formula}; the canal chokes at "
            f"{self.critical_speed:.3g} m/s."
        )

    def to_dict(self) -> dict[str, Any]:
        values = {name: value for name, value in vars(self).items() if name != "of"}
        values["sinkage"] = np.asarray(self.sinkage).tolist()
        values |= {"u": np.asarray(self.of[1]).tolist()} if self.of else {}
        return {**values, "notes": list(self.notes), "summary": self.summary()}


def ratios(configuration: Configuration, speed: float) -> dict[str, float]:
    """Return the quantities of validity ranges: froude, blockage, depth_to_draft, block_coefficient [1]."""
    ship, canal = configuration.ship, configuration.canal
    if canal.depth is None:
        raise InputError("[canal] depth is not given, and squat needs it; add it in metres")
    return {
        "froude": float(formulas.depth_froude(speed, canal.depth)),
        "blockage": float(formulas.blockage(ship.beam, ship.draft, canal.width, canal.depth)),
        "depth_to_draft": canal.depth / ship.draft,
        "block_coefficient": ship.block_coefficient,
    }


def limits_left(formula: SquatFormula, configuration: Configuration, speed: float) -> tuple[str, ...]:
    """Describe where a ship is outside the formula's range."""
    values = ratios(configuration, speed)
    return tuple(
        f"{name.replace('_', ' ')} {values[name]:.3g} is outside {low:g} to {high:g}"
        for name, (low, high) in formula.limits.items()
        if not low <= values[name] <= high
    )


@accept_aliases
def choke_speed(ship: Configured | Configuration) -> float:
    """Return the critical speed of a ship in its canal [m/s] (Schijf).

    Raises an InputError if the canal has no depth.

    Parameters
    ----------
    ship : Model or Configuration
        Ship and canal.

    Examples
    --------
    >>> round(nw.choke_speed(kcs), 1)
    8.6
    """
    configuration = configuration_of(ship)
    ratios(configuration, 0.0)
    return float(evaluate(formulas.critical_speed, configuration.values()))


def configuration_of(ship: Configured | Configuration) -> Configuration:
    """Return ship and canal of a model or the like; a configuration is returned unchanged."""
    if isinstance(ship, Configured):
        return ship.configuration
    if not isinstance(ship, Configuration):
        raise InputError(f"{shown(ship)} is no ship in a canal; give a model, or nw.Configuration(ship, canal)")
    return ship


@accept_aliases
def squat(
    ship: Configured | Configuration, u: Number, gives: Sinkage | None = None, formula: str | None = None
) -> Squat:
    """Estimate the sinkage of a ship at a speed.

    It uses the first formula of ``SQUAT`` that gives the requested sinkage and is valid here; if none is valid, the
    first that gives it, with notes. If the water of voyages (one-dimensional continuity and energy, with Barrass's
    trim) gives more, as near the critical speed, that is used: no ship is clear here that touches in a voyage.

    Raises an InputError if the depth is missing, the ship is as fast as the canal allows or faster, or a name is
    unknown.

    Parameters
    ----------
    ship : Model or Configuration
        Ship and canal; the depth must be given.
    u : float or array [m/s]
        Speed through the water, or several.
    gives : str, optional
        ``midship``, ``bow`` or ``largest``; that of the formula, or midship, unless given.
    formula : str, optional
        Formula to use instead.

    Examples
    --------
    >>> print(nw.squat(kcs, u=5.0).summary())
    The midship sinkage is 0.249 m by continuity; the canal chokes at 8.6 m/s.
    """
    if formula is not None:
        check_choice("formula", formula, SQUAT)
    check_choice("gives", gives or "midship", GIVES)
    kind: str = gives or (SQUAT[formula].gives if formula else "midship")
    if formula is not None and SQUAT[formula].gives != kind:
        own = SQUAT[formula].gives
        raise InputError(f"{formula} gives the {own} sinkage, not the {kind} one; leave gives out, or the formula")
    configuration, critical = configuration_of(ship), choke_speed(ship)
    if np.ndim(u) and np.size(u):
        each = [squat(ship, one, gives, formula) for one in np.ravel(u)]
        used = " or ".join(dict.fromkeys(one.formula for one in each))
        notes = tuple(dict.fromkeys(note for one in each for note in one.notes))
        sinkages = np.reshape([one.sinkage for one in each], np.shape(u))
        return Squat(sinkages, used, kind, critical, notes, (configuration, np.asarray(u)))
    if not is_finite(u):
        raise InputError(f"u = {shown(u)} is no speed in m/s; give a number or several")
    if not 0 <= u < critical:
        raise InputError(f"{u:.4g} m/s is not between 0 and the critical speed of this canal, {critical:.4g} m/s")
    offered = [formula] if formula else [name for name, chosen in SQUAT.items() if chosen.gives == kind]
    holding = [name for name in offered if not limits_left(SQUAT[name], configuration, u)]
    name = (holding or offered)[0]
    chosen = SQUAT[name]
    doubts = [f"{name} is {chosen.status}"] if chosen.status == UNVERIFIED else []
    notes = (*doubts, *limits_left(chosen, configuration, u))
    sinkage = float(evaluate(chosen.function, {**configuration.values(), "u": u}))
    if formula is None and (narrow := float(_of_voyages(configuration, u)[kind])) > sinkage:
        less = f"{name} gives less"
        return Squat(narrow, "continuity", kind, critical, (less,), (configuration, u))
    return Squat(sinkage, name, kind, critical, notes, (configuration, u))


def _of_voyages(configuration: Configuration, speed: float) -> dict[str, Number]:
    """Sinkages by kind [m] in the water in which voyages sail: continuity, energy and trim."""
    values = configuration.values()
    water, still = water_under_way(values, speed), values["depth"] - values["draft"]
    return {
        "midship": water.sinkage,
        # The trim of a fine ship lifts its bow, by a factor that is not verified: it is not counted on.
        "bow": np.maximum(water.sinkage, still - water.bow),
        "largest": still - np.minimum(water.bow, water.stern),
    }


class WaterUnderWay(NamedTuple):
    return_flow: Number  # Speed of the water past the ship, against its course [m/s]
    sinkage: Number  # Mean sinkage [m]
    bow: Number  # Clearance under the bow [m]
    stern: Number  # Clearance under the stern [m]


class SpeedsAfloat(NamedTuple):
    touching: Number  # Speed at which the deeper end touches the bottom; ``BOUNDLESS`` if none [m/s]
    choking: Number  # Speed at which the return flow is critical (Schijf) [m/s]


def water_under_way(values: Mapping[str, Number], speed: Number) -> WaterUnderWay:
    """Return the water around ships by particulars and section, below the choking speed; NaN above it."""
    # One-dimensional continuity and energy; the slender-body formula without banks if that gives more, as in wide
    # water.
    slow = np.abs(speed) < evaluate(formulas.critical_speed, values)
    below = {**values, "u": np.where(slow, np.abs(speed), 0.0)}
    sinkage = np.maximum(evaluate(formulas.continuity, below), evaluate(formulas.tuck_midship, below))
    deeper = formulas.deeper_end(values["block_coefficient"])  # The other end sinks by 2 less this
    full, still = is_full(values["block_coefficient"]), values["depth"] - values["draft"]
    found = (
        evaluate(formulas.return_flow, below), sinkage,
        still - sinkage * np.where(full, deeper, 2 - deeper), still - sinkage * np.where(full, 2 - deeper, deeper),
    )  # fmt: skip
    return WaterUnderWay(*(np.where(slow, one, np.nan) for one in found))


def speeds_afloat(values: Mapping[str, Number]) -> SpeedsAfloat:
    mean = maximum(values["depth"] - values["draft"], 0.0) / formulas.deeper_end(values["block_coefficient"])
    at = {**values, "sinkage": mean}
    touching = minimum(evaluate(formulas.speed_that_sinks, at), evaluate(formulas.speed_that_sinks_midship, at))
    choking = evaluate(formulas.critical_speed, values)
    return SpeedsAfloat(minimum(choice(choking - touching, touching, BOUNDLESS), BOUNDLESS), choking)


def is_full(block_coefficient: Number) -> Number:
    """Return whether a ship sinks most at the bow; a fine one does at the stern."""
    return np.asarray(block_coefficient) >= formulas.TRIMLESS


def displacement(configuration: Configuration) -> float:
    ship = configuration.ship
    return configuration.water.density * ship.length * ship.beam * ship.draft * ship.block_coefficient


def wetted_surface(ship: Ship) -> float:
    """Return the wetted surface of a hull by Denny and Mumford's formula [m2]."""
    return ship.length * (1.7 * ship.draft + ship.block_coefficient * ship.beam)


def ittc57(reynolds: float) -> float:
    """Return the frictional resistance coefficient of the ITTC's line of 1957 [1]."""
    return 0.075 / (math.log10(reynolds) - 2) ** 2


def ship_mass(configuration: Configuration) -> float:
    return configuration.ship.mass or displacement(configuration)


def ship_inertia(configuration: Configuration) -> float:
    """Return the yaw inertia of a ship, with the least radius of gyration, 0.2 L, if not given [kg m2]."""
    ship = configuration.ship
    return ship.inertia or ship_mass(configuration) * (0.2 * ship.length) ** 2
