"""The safe envelope: how fast, and how far off the middle of a canal, a ship is still in hand."""

import math
from dataclasses import replace

import numpy as np
import xarray as xr

from narrows.control.steady_course import check_rudder
from narrows.errors import InputError
from narrows.model.data_range import MEASURES, Measure, extrapolation
from narrows.model.model import Model
from narrows.quantities.constants import KNOT
from narrows.safety.answer import FIVE_PERCENT, MEDIAN, SafeEnvelope
from narrows.safety.disturbance import Disturbance
from narrows.safety.held_trials import Walls, trials
from narrows.safety.underkeel import Keel, keel_at
from narrows.ship.actuators import PROPELLER
from narrows.simulation.inputs import check_workers

RESERVE = 1 / 3
"""Of the rudder, to be left when the ship is steady."""
KEEL_SHARE = 0.05
"""Of the draft, to be left under the keel."""
OFFSETS, SPEEDS = 25, 15
SLOWEST, FASTEST = 0.3, 1.05
"""Of the speed that chokes the canal: the range where none is given."""
IN_KNOTS = {**MEASURES, "speed": Measure("speed", "knots", 1 / KNOT)}
"""How ranges of the data are spoken of on a bridge."""
SHIP_LENGTH = 30.0
"""Below this [m] a hull is taken for a model's."""
SQUARED = (
    "every force of these terms goes with the square of the speed, so the rudder that holds her is the same at any: "
    "what makes a fast ship harder to hold, beside squat and choking, is not in them"
)


def safe_envelope(
    model: Model, y: np.ndarray | None = None, u: np.ndarray | None = None, *,
    disturbance: Disturbance | None = None, reserve: float = RESERVE, keel: float | None = None, samples: int = 200,
    seed: int = 0, walls: Walls | None = None, workers: int | None = None, progress: bool = False,
) -> SafeEnvelope:  # fmt: skip
    """Find how fast and how far off the middle a ship is still in hand (ours).

    At each offset and speed the steady course is sought that holds her: rudder, heading and drift in balance. She is
    safe there where that course leaves a reserve of rudder, an autopilot with the real gear holds her against
    disturbances, the keel is clear and the canal is not choked. Coefficients are drawn from the covariance of the fit.

    Parameters
    ----------
    model : Model
        Of the ship at her own size, with the terms of a rudder.
    y : array (offsets,) [m], optional
        To starboard of the middle; as far as half a beam from either bank unless given.
    u : array (speeds,) [m/s], optional
        Through the water; to a little over the speed that chokes the canal unless given.
    disturbance : Disturbance, optional
        What throws her off.
    reserve : float [1]
        Of the rudder, to be left on the steady course.
    keel : float [m], optional
        Least clearance under the keel; a twentieth of the draft unless given.
    samples : int
        Of coefficients and disturbances.
    seed : int
        Of the samples.
    walls : pair of float [m], optional
        Where her keel meets the banks, to port and to starboard of the middle; the walls of the canal unless given.
    workers : int, optional
        Threads; all cores unless given.
    progress : bool
        Show a bar.

    Raises
    ------
    InputError
        Where the model has no rudder, nothing says how fast, or a number is out of range.
    """
    check_rudder(model)
    check_workers(workers)
    configuration = model.configuration
    least = KEEL_SHARE * configuration.ship.draft if keel is None else keel
    if not 0 <= reserve < 1 or not 0 <= least < math.inf:
        raise InputError(
            f"a reserve of {reserve} of the rudder and {least} m under the keel: give a share from 0 to less than 1, "
            "and metres from 0"
        )
    room = walls or (configuration.canal.width / 2, configuration.canal.width / 2)
    offsets = _offsets(model, room) if y is None else np.atleast_1d(np.asarray(y, float))
    speeds = _speeds(model) if u is None else np.atleast_1d(np.asarray(u, float))
    _check(offsets, speeds, room, configuration.ship.beam)
    under = keel_at(configuration, speeds)
    thrown = disturbance or Disturbance()
    tried = trials(model, offsets, speeds, under.midship, thrown, samples, seed, room, workers, progress)
    data = _summed(tried, (1 - reserve) * configuration.gear.limit)
    clear = ((under.clearance >= least) | (configuration.canal.depth is None)) & (speeds < under.choke)
    data = data.assign(clearance=("u", under.clearance, {"units": "m"}), clear=("u", clear))
    data["y"].attrs, data["u"].attrs = {"units": "m"}, {"units": "m/s"}
    notes = _notes(model, under, least, offsets, speeds)
    notes += (SQUARED,) if SafeEnvelope(data).speed_free else ()
    ends = {"wall_port": room[0], "wall_starboard": room[1]}
    return SafeEnvelope(data.assign_attrs(setting=_in_words(model), notes="\n".join(notes), **ends))


def _summed(tried: xr.Dataset, limit: float) -> xr.Dataset:
    """Samples as shares and quantiles; one without a course counts as beyond hard over, on the side of the others."""
    rudder = tried["rudder"]
    beyond = np.sign(rudder.median("sample")).fillna(1.0) * np.inf
    filled, size = rudder.fillna(beyond.where(beyond != 0, np.inf)), np.abs(rudder).fillna(np.inf)
    holds = size <= limit

    def quantile(values: xr.DataArray, share: float, method: str) -> xr.DataArray:
        with np.errstate(invalid="ignore"):
            found = values.quantile(share, "sample", method=method).drop_vars("quantile")
        return found.assign_attrs(units="rad")

    middle = quantile(filled, MEDIAN, "midpoint")
    return xr.Dataset(
        {
            "rudder": middle.where(np.isfinite(middle)).assign_attrs(units="rad"),
            "rudder_low": quantile(filled, 1 - FIVE_PERCENT, "lower"),
            "rudder_high": quantile(filled, FIVE_PERCENT, "higher"),
            "rudder_95": quantile(size, FIVE_PERCENT, "higher"),
            "found": np.isfinite(rudder).mean("sample").assign_attrs(units="1"),
            "holds": holds.mean("sample").assign_attrs(units="1"),
            "held": (holds & tried["held"]).mean("sample").assign_attrs(units="1"),
        }
    )


def _offsets(model: Model, room: Walls) -> np.ndarray:
    port, starboard = (wall - model.configuration.ship.beam for wall in room)
    if port + starboard <= 0:
        raise InputError("the canal is less than two beams wide: there is no offset to look at; check its width")
    return np.linspace(-port, starboard, OFFSETS)


def _speeds(model: Model) -> np.ndarray:
    choke = keel_at(model.configuration, np.empty(0)).choke
    if math.isinf(choke):
        raise InputError("without a depth nothing bounds the speed: give the canal's depth, or the speeds to look at")
    return np.linspace(SLOWEST, FASTEST, SPEEDS) * choke


def _check(offsets: np.ndarray, speeds: np.ndarray, room: Walls, beam: float) -> None:
    for name, column in (("offsets", offsets), ("speeds", speeds)):
        if not column.size or not np.isfinite(column).all() or (np.diff(column) <= 0).any():
            raise InputError(f"the {name} must be finite and rise; give them in order, none twice")
    if speeds[0] <= 0:
        raise InputError(f"a speed of {speeds[0]:g} m/s steers nothing; give speeds over 0")
    low, high = beam / 2 - room[0], room[1] - beam / 2
    if not (low < offsets[0] and offsets[-1] < high):
        raise InputError(
            f"offsets from {offsets[0]:g} to {offsets[-1]:g} m have the hull in a bank; stay between {low:.4g} and "
            f"{high:.4g} m"
        )


def _in_words(model: Model) -> str:
    ship, canal = model.configuration.ship, model.configuration.canal
    deep = "of unknown depth" if canal.depth is None else f"{canal.depth:.4g} m deep"
    size = f"{ship.length:.4g} x {ship.beam:.4g} x {ship.draft:.4g} m"
    return f"{ship.name}, {size}, in a canal {canal.width:.4g} m wide, {deep}"


def _notes(model: Model, under: Keel, least: float, offsets: np.ndarray, speeds: np.ndarray) -> tuple[str, ...]:
    bank = [model.bank_note] if model.bank_note else []
    notes, configuration = [*bank, *_beyond(model, offsets, speeds), *under.notes], model.configuration
    if model.covariance is None:
        notes.append("no covariance of the coefficients is known: the samples are of disturbances alone")
    if configuration.canal.depth is not None:
        notes.append(f"{least:.2g} m are to be left under the keel")
    gear = configuration.gear
    notes.append(f"rudder to {gear.limit_deg:.3g} degrees at {gear.rate_deg:.3g} degrees a second")
    if configuration.steering is None and configuration.ship.length < SHIP_LENGTH:
        notes.append("that gear is a ship's, and this is a model's size: scale the model, or give [steering] its rate")
    held = "the speed is held: what the propeller can give is not asked"
    turning = "; it turns as the speed asks straight ahead" if PROPELLER in model.terms.actuators else ""
    return (*notes, held + turning)


def _beyond(model: Model, offsets: np.ndarray, speeds: np.ndarray) -> tuple[str, ...]:
    """Where the question leaves what the tests covered; a place nearer to the middle than they were is inside."""
    known, configuration = model.data_range, model.configuration
    middle = replace(known, abs_y=known.abs_y and (0.0, known.abs_y[1]))
    asked = {
        "speed": speeds,
        "abs_y": np.abs(offsets).max(),
        "depth_to_draft": configuration.canal.depth and configuration.canal.depth / configuration.ship.draft,
        "width_to_beam": configuration.canal.width / configuration.ship.beam,
    }
    return extrapolation(middle, {n: own for n, own in asked.items() if own is not None}, IN_KNOTS, unknown=True)
