"""Bank suction and bow-out moment (bank cushion) in any section, with uncertainty; exported files compute the same."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import BaseResult
from narrows.model.data_range import DataRange, extrapolation, sum_beyond
from narrows.model.model import Model
from narrows.quantities.names import Number
from narrows.ship.checks import check_angles
from narrows.ship.motion import Motion

if TYPE_CHECKING:
    import pandas as pd


CONTACT = 64  # Bit of ``beyond`` where the hull touches a bank
# Largest heading along the banks [rad]: an unknown range of headings ends here. A degree passed as a radian exceeds it.
ALONG = math.pi / 4


@dataclass(frozen=True, repr=False)
class BankForce(BaseResult):
    """The force of the banks on a ship; arrays for array inputs."""

    Y: Number  #: Sway force [N], positive to starboard
    N: Number  #: Yaw moment about midship [N m], positive if it turns the bow to starboard
    #: Standard deviation of ``Y`` from the uncertainty of the coefficients [N]; NaN without a covariance
    Y_deviation: Number
    N_deviation: Number  #: Standard deviation of ``N`` [N m]
    #: 0 if the tests of the model covered the input; else a sum of 1 speed, 2 offset, 4 heading, 16 width, 32 depth,
    #: and 64 if the hull touches a bank. Where no range of headings is known, a heading over 45 degrees counts.
    beyond: Number
    notes: tuple[str, ...]  #: Limits of the tests: coefficients they do not determine, ranges they did not cover

    def __iter__(self) -> Iterator[Number]:
        """Y and N, as in ``Y, N = nw.bank_force(model, y, u)``."""
        return iter((self.Y, self.N))

    @property
    def _numbers(self) -> dict[str, Number]:
        return {name: getattr(self, name) for name in ("Y", "N", "Y_deviation", "N_deviation", "beyond")}

    def summary(self) -> str:
        parts = [("Y", self.Y, self.Y_deviation, "N"), ("N", self.N, self.N_deviation, "N m")]
        lines = [f"{name} {_shown(value)} {unit}, {_doubt(deviation, unit)}." for name, value, deviation, unit in parts]
        return "\n".join([*lines, *self.notes])

    def to_dataframe(self) -> "pd.DataFrame":
        """Return one row per input."""
        import pandas as pd

        return pd.DataFrame({name: np.ravel(value) for name, value in self._numbers.items()})

    def to_dict(self) -> dict[str, Any]:
        rows = {name: np.asarray(value).tolist() for name, value in self._numbers.items()}
        return {**rows, "notes": list(self.notes), "summary": self.summary()}


def _shown(value: Number) -> str:
    low, high = np.min(value), np.max(value)
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def _doubt(deviation: Number, unit: str) -> str:
    known = not np.any(np.isnan(deviation))
    return f"standard deviation {_shown(deviation)} {unit}" if known else "its standard deviation is not known"


@accept_aliases
def bank_force(
    model: Model, y: Number, u: Number, psi: Number = 0.0, *, starboard: Number | None = None,
    port: Number | None = None, depth: Number | None = None, slope_starboard: Number = 0.0, slope_port: Number = 0.0,
) -> BankForce:  # fmt: skip
    """Evaluate the force of the banks on a ship, with standard deviations and a flag for untested inputs.

    ``narrows export bank-force`` writes the same function for simulators. A sloped bank acts like the wall that gives
    the same section of water. Numbers may be arrays of one shape.

    Raises an InputError if the model has no bank force, its bank terms need a depth, or no water is left between the
    banks.

    Parameters
    ----------
    model : Model
        A model with a bank term.
    y : number [m]
        Offset of midship to starboard of the line.
    u : number [m/s]
        Surge velocity through the water.
    psi : number [rad]
        Heading from the direction of the line, clockwise seen from above.
    starboard, port : number, optional [m]
        Distance from the line to the foot of each bank; half the width of the model's canal unless given.
    depth : number, optional [m]
        Water depth; that of the model's canal unless given.
    slope_starboard, slope_port : number [1]
        Horizontal distance per metre of height of a bank; 0 for a wall.

    Examples
    --------
    >>> import narrows as nw
    >>> dtc = nw.published("mikkelsen2025_dtc")
    >>> force = nw.bank_force(dtc, 0.8, 1.0, starboard=3.5, port=3.2)
    >>> force.Y > 0 > force.N  # towards the near bank, the bow away from it
    True
    """
    if not model.has_bank:
        raise InputError(model.bank_note)
    check_angles({"psi": psi})
    canal = model.configuration.canal
    depth = canal.depth if depth is None else depth
    deep: Number = 0.0 if depth is None else depth
    feet = [canal.width / 2 if foot is None else foot for foot in (starboard, port)]
    slopes = (slope_starboard, slope_port)
    right, left = (foot + 0.5 * slope * deep for foot, slope in zip(feet, slopes, strict=True))
    width, offset = right + left, y - 0.5 * (right - left)
    if depth is None and any(map(np.any, slopes)):
        raise InputError("a sloped bank needs a depth of the water; give depth")
    ship = model.configuration.ship
    deep_enough = depth is None or np.all(np.asarray(depth) > ship.draft)
    if not (deep_enough and np.all((width > 0) & np.isfinite(width))):
        raise InputError("the banks leave no water; give distances to both over 0 m, and a depth over the draft")
    motion = Motion.at(y=offset, psi=psi, u=u)
    values = {**model.configuration.values(), **motion.values(), "width": width, "depth": depth}
    forces = [_with_deviation(model, force, values) for force in "YN"]
    asked = {"speed": u, "abs_y": abs(offset), "abs_psi": abs(psi), "width_to_beam": width / ship.beam}
    asked |= {} if depth is None else {"depth_to_draft": depth / ship.draft}
    # The keel touches a slope at its draft, if not the side the equivalent wall before.
    free = np.minimum(0.5 * deep, deep - ship.draft)
    reach = 0.5 * ship.length * abs(np.sin(psi)) + 0.5 * ship.beam * np.cos(psi)
    walls = [foot + slope * free for foot, slope in zip(feet, slopes, strict=True)]
    touches = np.logical_not((y + reach < walls[0]) & (reach - y < walls[1]))
    known = beside_banks(model)
    contact = ("The hull touches a bank: the force has no meaning there.",) if np.any(touches) else ()
    notes = (*model.bank_notes, *extrapolation(known, asked), *contact)
    (Y, Y_deviation), (N, N_deviation) = forces
    beyond = sum_beyond(known, asked) + CONTACT * np.asarray(touches, int)
    return BankForce(Y, N, Y_deviation, N_deviation, beyond, notes)


def beside_banks(model: Model) -> DataRange:
    """Return the ranges of the data; an unknown range of headings is any along the banks."""
    return replace(model.data_range, abs_psi=model.data_range.abs_psi or (0.0, ALONG))


def _with_deviation(model: Model, force: str, values: dict[str, Number]) -> tuple[Number, Number]:
    """Return the bank's part of a force, and its standard deviation: it is linear in the coefficients."""
    terms = [term for term in model.terms.forces[force] if term.from_bank]
    for name in {name for term in terms for name in term.inputs}:
        if values.get(name) is None:
            raise InputError(f"the bank terms of this model need {name}; give it")
    columns = [term.column(values) for term in terms]
    # Not by sum(), as in ``Model.bank_forces``.
    parts = (model[term.name] * column for term, column in zip(terms, columns, strict=True))
    total = reduce(add, parts, 0.0 * values["y"])
    if model.covariance is None:
        return total, total * np.nan
    places = [model.terms.names.index(term.name) for term in terms]
    spread = model.covariance[np.ix_(places, places)]
    number = range(len(places))
    variance: Number = sum(spread[i, j] * columns[i] * columns[j] for i in number for j in number)
    return total, np.sqrt(variance)
