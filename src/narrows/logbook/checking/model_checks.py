"""The record beside the model: which way its rudder turns it, and where on the ship its position is measured."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook.checking.agreement import SURE, Estimates, least_squares, pooled
from narrows.logbook.checking.even_motion import changes
from narrows.logbook.checking.examined import Examined
from narrows.logbook.checking.finding import Finding
from narrows.logbook.checking.model_rates import ModelRates

# Windows over which the rudder's effect is sought, in times for a ship length.
LENGTHS = (0.5, 1.0)
# Of a ship length, by which a model's drift in turns may put the antenna wrong.
AMIDSHIPS = 0.2
# Times what the model says that a rudder's effect is, in which it is one of another sign or unit.
WEAK, STRONG = 0.25, 5.0


def rudder_effect(at: Examined, rates: ModelRates) -> Estimates | None:
    """Return how many times the model's the rudder's effect on the yaw rate is; None where it is not told."""
    motion, without = at.motion, rates.acceleration(5, rudder=0.0)
    effect, rest = rates.whole(rates.acceleration(5) - without), rates.whole(without)
    turning = rates.whole(rates.state["r"])
    found = []
    for lengths in LENGTHS:
        windows = motion.windows(lengths)
        expected = motion.integrals(effect, windows)
        change = changes(turning, windows) - motion.integrals(rest, windows)
        if told := least_squares(change, [expected, np.ones(len(expected))]):
            found.append(told)
    return min(found, key=lambda told: told.errors[0], default=None)


def judge_rudder(effects: list[tuple[float, float]], record: str) -> Iterator[Finding]:
    """Yield what is wrong with the rudder's sign or unit, by its effect in one record or in several."""
    # effects (float, float)
    if (told := pooled(effects)) is None:
        return
    effect, error, records = told
    evidence = {"effect": effect, "error": error, "records": float(records)}
    seen = f"the rudder turns the ship by {effect:.2f} +- {1.96 * error:.2f} times what the model says"
    if effect + SURE * error < -WEAK:
        remedy = 'turn its sign ([positive] rudder = "port"): positive turns the bow to starboard'
        yield Finding("rudder's sign", record, seen, remedy, evidence)
    elif effect - SURE * error > STRONG:
        yield Finding("rudder's unit", record, seen, "it looks like radians taken as degrees: check its unit", evidence)


def check_antenna(at: Examined, rates: ModelRates) -> Iterator[Finding]:
    """Yield where the position is measured elsewhere on the ship than is said, by how it swings in turns."""
    found = _forward(at, rates)
    if found is None:
        return
    forward, error, said = found.values[0], found.errors[0], at.record.antenna[0]
    if abs(forward - said) > AMIDSHIPS * at.length + SURE * error:
        where = "forward" if forward > 0 else "aft"
        yield at.finding(
            "antenna", f"in turns the position swings as that of a point {abs(forward):.3g} +- {1.96 * error:.2g} m "
            f"{where} of midship, and it is said to be {said:g} m forward",
            "give the antenna's place, forward and to starboard of midship",
            {"forward": forward, "error": error, "said": said},
        )  # fmt: skip


def _forward(at: Examined, rates: ModelRates) -> Estimates | None:
    """How far forward of midship the position is measured [m], with the surge's size and the current beside it."""
    motion = at.motion
    windows = motion.windows(1.0)
    ahead = np.exp(1j * motion.heading)
    turning, surge = rates.whole(rates.state["r"]), rates.whole(rates.state["u"])
    way = changes(motion.position, windows) - motion.integrals(1j * rates.sway() * ahead, windows)
    drifts = np.full(len(way), motion.dt * (windows[1] - windows[0])[0] if len(way) else 0.0)
    regressors = [
        motion.integrals(1j * turning * ahead, windows), motion.integrals(surge * ahead, windows), drifts, 1j * drifts
    ]  # fmt: skip
    return least_squares(_stacked(way), [_stacked(column) for column in regressors])


def _stacked(column: np.ndarray) -> np.ndarray:
    """Real and imaginary parts, below each other."""
    return np.concatenate([column.real, column.imag])
