"""The safe envelope: how fast, and how far off the middle of a canal, a ship is still in hand."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr

from narrows.control.self_propulsion import with_propulsion
from narrows.control.steady_course import check_rudder, steady_course
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.safety.answer import MEDIAN, SURE_SHARE, SafeEnvelope
from narrows.safety.disturbance import Disturbance
from narrows.safety.held_trials import Walls, trials
from narrows.safety.sampling import is_settled, share_interval
from narrows.safety.tested import beyond_tests, tested_ranges, untested_section, within_tests
from narrows.safety.underkeel import Keel, keel_at
from narrows.simulation.inputs import check_workers

RESERVE = 1 / 3
"""Of the rudder, to be left when the ship is steady."""
KEEL_SHARE = 0.05
"""Of the draft, to be left under the keel."""
OFFSETS, SPEEDS = 25, 15
SLOWEST, FASTEST = 0.3, 1.05
"""Of the speed that chokes the canal: the range where none is given."""
FIRST_SAMPLES, MOST_SAMPLES = 400, 6400
"""Tried at first where no number is given, and doubled until the edge is settled, up to so many."""
SHIP_LENGTH = 30.0
"""Below this [m] a hull is taken for a model's."""
SQUARED = (
    "every force of these terms goes with the square of the speed, so the rudder that holds the ship is the same at "
    "any: what makes a fast ship harder to hold, beside squat and choking, is not in them"
)


def safe_envelope(
    model: Model, y: np.ndarray | None = None, u: np.ndarray | None = None, *,
    disturbance: Disturbance | None = None, reserve: float = RESERVE, keel: float | None = None,
    most_revolutions: float | None = None, samples: int | None = None, seed: int = 0, walls: Walls | None = None,
    workers: int | None = None, progress: bool = False,
) -> SafeEnvelope:  # fmt: skip
    """Find how fast and how far off the middle a ship is still in hand (ours).

    At each offset and speed the steady course is sought that holds it: rudder, heading and drift in balance. The ship
    is safe there where that course leaves a reserve of rudder, an autopilot with the real gear holds it against
    disturbances, the keel is clear and the canal is not choked. Coefficients are drawn from the covariance of the fit.

    Parameters
    ----------
    model : Model
        Of the ship at its own size, with the terms of a rudder.
    y : array (offsets,) [m], optional
        To starboard of the middle; as far as half a beam from either bank unless given.
    u : array (speeds,) [m/s], optional
        Through the water; to a little over the speed that chokes the canal unless given.
    disturbance : Disturbance, optional
        What throws the ship off.
    reserve : float [1]
        Of the rudder, to be left on the steady course.
    keel : float [m], optional
        Least clearance under the keel; a twentieth of the draft unless given.
    most_revolutions : float [1/s], optional
        Of the engine, where the model has a propeller: faster than that it cannot go, and what a kick ahead with it
        saves of the rudder is told.
    samples : int, optional
        Of coefficients and disturbances; unless given as many as settle the edge to a step of the offsets and speeds.
    seed : int
        Of the samples.
    walls : pair of float [m], optional
        Where its keel meets the banks, to port and to starboard of the middle; the walls of the canal unless given.
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
    under = keel_at(model, speeds)
    clear = ((under.clearance >= least) | (configuration.canal.depth is None)) & (speeds < under.choke)
    driven = _driven(model, speeds, most_revolutions)
    tested = within_tests(model, offsets, speeds)
    thrown, limit = disturbance or Disturbance(), (1 - reserve) * configuration.gear.limit
    try_more = partial(
        trials, model, offsets, speeds, under.midship, thrown, walls=room, workers=workers, progress=progress
    )
    tried = _settled(try_more, samples, seed, limit, clear & driven & tested)
    data = _summed(tried, limit).transpose("y", "u")
    data = data.assign(
        clearance=("u", under.clearance, {"units": "m"}), clear=("u", clear & driven), driven=("u", driven),
        tested=(("y", "u"), tested),
    )  # fmt: skip
    if most_revolutions is not None:
        data = data.assign(rudder_kick=_kick(model, offsets, speeds, under, most_revolutions))
    data["y"].attrs, data["u"].attrs = {"units": "m"}, {"units": "m/s"}
    notes = _notes(model, under, least, offsets, speeds, most_revolutions)
    notes += (SQUARED,) if SafeEnvelope(data).speed_free else ()
    told = {
        "setting": f"{configuration.ship.in_words}, in {configuration.canal.in_words}",
        "weather": thrown.words,
        "notes": "\n".join(notes),
        "beam": model.configuration.ship.beam,
    }
    told |= {"wall_port": room[0], "wall_starboard": room[1], "rudder_limit": configuration.gear.limit}
    told |= {"reserve": reserve, "samples": tried.sizes["sample"], "untested": untested_section(model)}
    told |= {"trust": model.trust_note}
    return SafeEnvelope(data.assign_attrs(told | tested_ranges(model)))


Trial = Callable[..., xr.Dataset]


def _settled(try_more: Trial, samples: int | None, seed: int, limit: float, clear: np.ndarray) -> xr.Dataset:
    """Trials of so many samples, or of twice as many again and again until the edge is settled."""
    if samples is not None:
        return try_more(samples=samples, seed=seed)
    tried, rounds = try_more(samples=FIRST_SAMPLES, seed=seed), 0
    while (count := tried.sizes["sample"]) < MOST_SAMPLES:
        held = ((np.abs(tried["rudder"]) <= limit) & tried["held"]).mean("sample").transpose("y", "u").to_numpy()
        if is_settled(*share_interval(held, count), SURE_SHARE, clear):
            break
        rounds += 1
        another = int(np.random.SeedSequence((seed, rounds)).generate_state(1)[0])
        tried = xr.concat([tried, try_more(samples=count, seed=another)], "sample")
    return tried


def _driven(model: Model, speeds: np.ndarray, most: float | None) -> np.ndarray:
    """Whether the engine turns the propeller as fast as each speed asks; true where nothing says how fast it turns."""
    if most is None:
        return np.ones(len(speeds), bool)
    if not model.terms.propelled:
        raise InputError(f"most_revolutions = {most} 1/s, but this model has no terms of a propeller; leave it out")
    if not 0 < most < math.inf:
        raise InputError(f"most_revolutions = {most} 1/s drive no ship; give a number over 0")
    asked: object = with_propulsion(model, {"u": speeds})["revolutions"]
    return np.asarray(asked, float) <= most


def _kick(model: Model, offsets: np.ndarray, speeds: np.ndarray, under: Keel, most: float) -> xr.DataArray:
    """The steady rudder with the engine at its most [rad]."""
    heave = xr.DataArray(under.midship, dims="u")
    course = steady_course(model, y=offsets, u=speeds, heave=heave, revolutions=most)
    return course["rudder"].transpose("y", "u").drop_vars(["y", "u"], errors="ignore")


def _summed(tried: xr.Dataset, limit: float) -> xr.Dataset:
    """Samples as shares and quantiles; one without a course counts as beyond hard over, on the side of the others."""
    rudder = tried["rudder"]
    beyond = np.sign(rudder.median("sample")).fillna(1.0) * np.inf
    filled, size = rudder.fillna(beyond.where(beyond != 0, np.inf)), np.abs(rudder).fillna(np.inf)
    holds = size <= limit

    def quantile(values: xr.DataArray, share: float, method: str) -> xr.DataArray:
        with np.errstate(invalid="ignore"):
            quantiles = values.quantile(share, "sample", method=method).drop_vars("quantile")
        return quantiles.assign_attrs(units="rad")

    middle = quantile(filled, MEDIAN, "midpoint")
    return xr.Dataset(
        {
            "rudder": middle.where(np.isfinite(middle)).assign_attrs(units="rad"),
            "rudder_low": quantile(filled, 1 - SURE_SHARE, "lower"),
            "rudder_high": quantile(filled, SURE_SHARE, "higher"),
            "rudder_95": quantile(size, SURE_SHARE, "higher"),
            "found": np.isfinite(rudder).mean("sample").assign_attrs(units="1"),
            "holds": holds.mean("sample").assign_attrs(units="1"),
        }
    ).assign(_held((holds & tried["held"]).mean("sample"), tried.sizes["sample"]))


def _held(share: xr.DataArray, count: int) -> dict[str, xr.DataArray]:
    """The share that is held, and its interval for so many samples."""
    low, high = (share.copy(data=end) for end in share_interval(share.to_numpy(), count))
    return {
        name: values.assign_attrs(units="1")
        for name, values in {"held": share, "held_low": low, "held_high": high}.items()
    }


def _offsets(model: Model, room: Walls) -> np.ndarray:
    port, starboard = (wall - model.configuration.ship.beam for wall in room)
    if port + starboard <= 0:
        raise InputError("the canal is less than two beams wide: there is no offset to look at; check its width")
    covered = model.data_range.abs_y
    ends = [] if covered is None else [end for end in (-covered[1], covered[1]) if -port < end < starboard]
    return np.union1d(np.linspace(-port, starboard, OFFSETS), ends)


def _speeds(model: Model) -> np.ndarray:
    choke = keel_at(model, np.empty(0)).choke
    if math.isinf(choke):
        raise InputError("without a depth nothing bounds the speed: give the canal's depth, or the speeds to look at")
    asked = np.linspace(SLOWEST, FASTEST, SPEEDS) * choke
    covered = model.data_range.speed or ()
    return np.union1d(asked, [end for end in covered if asked[0] < end < asked[-1]])


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


def _notes(
    model: Model, under: Keel, least: float, offsets: np.ndarray, speeds: np.ndarray, most: float | None
) -> tuple[str, ...]:
    notes, configuration = [*model.bank_notes, *beyond_tests(model, offsets, speeds), *under.notes], model.configuration
    if model.covariance is None:
        notes.append("no covariance of the coefficients is known: the samples are of disturbances alone")
    if configuration.canal.depth is not None:
        notes.append(f"{least:.2g} m are to be left under the keel")
    gear = configuration.gear
    notes.append(f"rudder to {gear.limit_deg:.3g} degrees at {gear.rate_deg:.3g} degrees a second")
    if configuration.steering is None and configuration.ship.length < SHIP_LENGTH:
        notes.append("that gear is a ship's, and this is a model's size: scale the model, or give [steering] its rate")
    return (*notes, _propulsion(model, most))


def _propulsion(model: Model, most: float | None) -> str:
    if not model.terms.propelled:
        return "the speed is held: what the propeller can give is not asked"
    turning = "the propeller turns as the speed asks straight ahead"
    if most is None:
        return f"the speed is held: {turning}, however fast that is; give the engine's most revolutions to bound it"
    return f"the speed is held: {turning}, up to {most:g} revolutions a second"
