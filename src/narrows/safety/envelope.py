"""The safe envelope: how fast, and how far off the centreline, a ship stays controllable."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import xarray as xr

from narrows.aliases import accept_aliases
from narrows.control.steady_course import check_rudder, solved, with_propulsion
from narrows.errors import InputError, check_choice
from narrows.model.model import Model
from narrows.safety import settings
from narrows.safety.caveats import data_coverage, with_caveats
from narrows.safety.held_trials import trials
from narrows.safety.pilots import PILOTS, Pilot
from narrows.safety.request import Bend, Disturbance, EnvelopeRequest, Keel, Walls, envelope_request, keel_at
from narrows.safety.result import MEDIAN, SafeEnvelope
from narrows.simulation.grid import grid_of
from narrows.simulation.inputs import check_workers, finite_numbers
from narrows.simulation.ship import SimulatedShip


@accept_aliases
def safe_envelope(
    model: Model, y: np.ndarray | None = None, u: np.ndarray | None = None, *,
    disturbance: Disturbance | None = None, reserve: float = settings.RESERVE, keel: float | None = None,
    most_revolutions: float | None = None, samples: int | None = None, seed: int = 0, walls: Walls | None = None,
    bank: str = "steep", controller: str = "regulator", curvature: float = 0.0, current: float = 0.0,
    workers: int | None = None, progress: bool = False,
) -> SafeEnvelope:  # fmt: skip
    """Find the speeds and offsets at which a ship stays controllable in its canal.

    At each offset and speed it computes the steady course: rudder, heading and drift in equilibrium. The ship is safe
    there if that course leaves a reserve of rudder, a pilot with the real gear and without the true coefficients holds
    it against disturbances, the keel is clear and the canal is not choked. The result also shows where a pilot with the
    true coefficients holds it. Coefficients are drawn from the covariance of the fit.

    Parameters
    ----------
    model : Model
        A model at the ship's own size, with the terms of a rudder.
    y : array (offsets,) [m], optional
        Offsets to starboard of the middle; default: up to half a beam from either bank.
    u : array (speeds,) [m/s], optional
        Speeds through the water; default: to a little over the choking speed.
    disturbance : Disturbance, optional
        Initial deviations and gusts.
    reserve : float [1]
        Share of the rudder left on the steady course.
    keel : float [m], optional
        Least clearance under the keel; a twentieth of the draft unless given.
    most_revolutions : float [1/s], optional
        Limit of the engine, for a model with a propeller: it limits the speed, and the result shows how much rudder a
        kick ahead saves.
    samples : int, optional
        Number of samples of coefficients and disturbances; default: enough to determine the edge to a step of the
        offsets and speeds.
    seed : int
        Seed of the samples.
    walls : pair of float [m], optional
        Places where the keel meets the banks, to port and to starboard of the middle; default: the canal's walls.
    bank : str
        Kind of bank for the comparison with outside rules: ``gentle``, ``sloping`` or ``steep``.
    controller : str
        Pilot without the true coefficients: ``regulator``, the best available; ``track``, that of earlier versions;
        ``human``, a helmsman with delay, whole degrees and a limit.
    curvature : float [1/m]
        Curvature of the canal, to starboard: in a bend the steady turn leaves the reserve, and trials sail it.
    current : float [m/s]
        Along the canal, with the ship.
    workers : int, optional
        Threads; all cores unless given.
    progress : bool
        Show a bar.

    Raises
    ------
    InputError
        If the model has no rudder, no speed is known, a number is out of range, or a bank or pilot is unknown.
    """
    check_rudder(model)
    check_workers(workers)
    check_choice("controller", controller, PILOTS)
    bend = Bend(**finite_numbers(curvature=curvature, current=current))
    request = envelope_request(model, y, u, disturbance, reserve, keel, most_revolutions, walls, bank, controller, bend)
    under = keel_at(model, request.speeds)
    bounds = bounds_of(request, under)
    inside = (bounds["tested"] & bounds["clear"]).to_numpy()
    pilot = choose_pilot(request, under.midship, bounds["clear"].to_numpy(), seed, workers)
    try_more = partial(
        trials, y=request.offsets, u=request.speeds, heave=under.midship, disturbance=request.disturbance,
        walls=request.walls, bend=request.bend, pilot=pilot, workers=workers, progress=progress,
    )  # fmt: skip
    tried = settled_trials(partial(try_more, model), samples, seed, request.rudder_limit, inside)
    likely = tried
    if model.covariance is not None:
        likely = try_more(replace(model, covariance=None), samples=settings.LIKELY_SAMPLES, seed=seed)
    data = controllable_fraction(tried, request.rudder_limit).assign(bounds.data_vars)
    data = data.assign(best_estimate_fraction(likely, request.rudder_limit))
    if most_revolutions is not None:
        data = data.assign(rudder_kick=rudder_of_propeller_burst(request, under))
    data["y"].attrs, data["u"].attrs = {"units": "m"}, {"units": "m/s"}
    return with_caveats(SafeEnvelope(data), request, under, tried.sizes["sample"])


def bounds_of(request: EnvelopeRequest, under: Keel) -> xr.Dataset:
    """Return the clearance of the keel, where the engine reaches the revolutions, where all is clear, and the tests."""
    model, speeds = request.model, request.speeds
    driven = _driven(model, speeds, request.most_revolutions)
    floating = (under.clearance >= request.clearance) | (model.configuration.canal.depth is None)
    return xr.Dataset({
        "clearance": ("u", under.clearance, {"units": "m"}),
        "clear": ("u", floating & (speeds < under.choke) & driven),
        "driven": ("u", driven),
        "tested": (("y", "u"), data_coverage(model, request.offsets, speeds)),
    })  # fmt: skip


def _driven(model: Model, speeds: np.ndarray, most: float | None) -> np.ndarray:
    """Return whether the engine reaches the revolutions of each speed; true if its limit is unknown."""
    if most is None:
        return np.ones(len(speeds), bool)
    if not model.terms.propelled:
        raise InputError(f"most_revolutions = {most} 1/s, but this model has no terms of a propeller; leave it out")
    if not 0 < most < math.inf:
        raise InputError(f"most_revolutions = {most} 1/s drive no ship; give a number over 0")
    asked: object = with_propulsion(model, {"u": speeds})["revolutions"]
    return np.asarray(asked, float) <= most


def rudder_of_propeller_burst(request: EnvelopeRequest, under: Keel) -> xr.DataArray:
    """Return the steady rudder with the engine at its limit, over offsets and speeds [rad]."""
    asked = {"u": request.speeds, "heave": xr.DataArray(under.midship, dims="u"), "y": request.offsets}
    grid = grid_of(request.model, {**asked, "revolutions": request.most_revolutions}, 0, 0)
    values, shape = grid.flat(slice(0, grid.sizes[grid.axis]))
    ship, wind = SimulatedShip(request.model), request.disturbance.steady
    sides = [
        solved(ship, {**values, **request.bend.values(values["y"]), "Y": force,
                      "N": request.disturbance.gust_lever * force}, grid.vessels, 1)[1]
        for force in (wind, -wind)
    ]  # fmt: skip
    rudder = np.where(np.abs(sides[0]) >= np.abs(sides[1]), *sides)
    return xr.DataArray(rudder.reshape(shape), dims=list(grid.sizes), attrs={"units": "rad"}).transpose("y", "u")


def choose_pilot(
    request: EnvelopeRequest, heave: np.ndarray, clear: np.ndarray, seed: int, workers: int | None
) -> Pilot:  # fmt: skip
    """Return a pilot with the tuning alone that holds most samples at a few of the requested offsets and speeds."""
    # heave (speeds,) [m]; clear (speeds,)
    pilot = PILOTS[request.pilot]
    if len(pilot.tunings) == 1:
        return pilot
    open_to = np.flatnonzero(clear) if clear.any() else np.arange(len(request.speeds))
    speeds = open_to[_spread(len(open_to), settings.TUNING_SPEEDS)]
    offsets = _spread(len(request.offsets), settings.TUNING_OFFSETS)
    other_seed = int(np.random.SeedSequence((abs(seed), settings.TUNING_SEED)).generate_state(1)[0])
    shares = []
    tunings = [replace(pilot, tunings=(tuning,)) for tuning in pilot.tunings]
    for tuned in tunings:
        tried = trials(
            request.model, request.offsets[offsets], request.speeds[speeds], heave[speeds],
            request.disturbance, settings.TUNING_SAMPLES, other_seed, request.walls, tuned,
            bend=request.bend, knowing=False, workers=workers,
        )  # fmt: skip
        safe = (np.abs(tried["rudder"]) <= request.rudder_limit) & tried["held"]
        shares.append(float(safe.mean()))
    return tunings[int(np.argmax(shares))]


def _spread(size: int, most: int) -> np.ndarray:
    """Return at most ``most`` places of a row, evenly spaced, without its ends if there are more."""
    if size <= most:
        return np.arange(size)
    return np.unique(np.round((np.arange(most) + 0.5) * size / most - 0.5).astype(int))


# Trials of so many ``samples`` from a ``seed``, over y, u and sample.
Trial = Callable[..., xr.Dataset]


def settled_trials(try_more: Trial, samples: int | None, seed: int, limit: float, clear: np.ndarray) -> xr.Dataset:
    """Return trials of so many samples, or doubled until the edge is determined."""
    # limit [rad]; clear (offsets, speeds)
    if samples is not None:
        return try_more(samples=samples, seed=seed)
    tried, rounds = try_more(samples=settings.FIRST_SAMPLES, seed=seed), 0
    while (count := tried.sizes["sample"]) < settings.MOST_SAMPLES:
        held = safely(tried, limit, "held").mean("sample").transpose("y", "u").to_numpy()
        if is_settled(*share_interval(held, count), settings.SURE_SHARE, clear):
            break
        rounds += 1
        another = int(np.random.SeedSequence((seed, rounds)).generate_state(1)[0])
        tried = xr.concat([tried, try_more(samples=count, seed=another)], "sample")
    return tried


def controllable_fraction(tried: xr.Dataset, limit: float) -> xr.Dataset:
    # tried [rad]; limit [rad]. A sample without a course counts as beyond hard over, on the side of the others.
    found, holds = np.isfinite(tried["rudder"]), np.abs(tried["rudder"]) <= limit
    shares = {"found": found.mean("sample"), "holds": holds.mean("sample")}
    for name in ("held", "known"):
        shares |= _counted(name, safely(tried, limit, name))
    counted = {name: share.assign_attrs(units="1") for name, share in shares.items()}
    return xr.Dataset(_quantiles(tried["rudder"]) | counted).transpose("y", "u")


def safely(tried: xr.Dataset, limit: float, name: str) -> xr.DataArray:
    return (np.abs(tried["rudder"]) <= limit) & tried[name]


def best_estimate_fraction(tried: xr.Dataset, limit: float) -> dict[str, xr.DataArray]:
    """Return the results for the best estimate, over y and u: ``certain``, ``rudder_likely``."""
    share = safely(tried, limit, "known").mean("sample").assign_attrs(units="1")
    # A steady wind may blow from either side: the larger rudder counts, and none where one side has no course.
    most, least = (getattr(tried["rudder"], of)("sample", skipna=False) for of in ("max", "min"))
    return {"certain": share, "rudder_likely": xr.where(abs(most) >= abs(least), most, least).assign_attrs(units="rad")}


def _counted(name: str, counted: xr.DataArray) -> dict[str, xr.DataArray]:
    """Share of the samples that satisfy a condition, and its confidence interval."""
    share = counted.mean("sample")
    low, high = (share.copy(data=end) for end in share_interval(share.to_numpy(), counted.sizes["sample"]))
    return {name: share, f"{name}_low": low, f"{name}_high": high}


def _quantiles(rudder: xr.DataArray) -> dict[str, xr.DataArray]:
    beyond = np.sign(rudder.median("sample")).fillna(1.0) * np.inf
    filled, size = rudder.fillna(beyond.where(beyond != 0, np.inf)), np.abs(rudder).fillna(np.inf)
    middle = _quantile(filled, MEDIAN, "midpoint")
    return {
        "rudder": middle.where(np.isfinite(middle)).assign_attrs(units="rad"),
        "rudder_low": _quantile(filled, 1 - settings.SURE_SHARE, "lower"),
        "rudder_high": _quantile(filled, settings.SURE_SHARE, "higher"),
        "rudder_95": _quantile(size, settings.SURE_SHARE, "higher"),
    }


def _quantile(values: xr.DataArray, share: float, method: str) -> xr.DataArray:
    with np.errstate(invalid="ignore"):
        quantiles = values.quantile(share, "sample", method=method).drop_vars("quantile")
    return quantiles.assign_attrs(units="rad")


# Standard deviations of a two-sided 95 % interval of a normal distribution.
QUANTILE_95 = 1.959964


def share_interval(share: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the 95 % interval of a counted share, low and high [1]."""
    # Wilson (1927), Probable inference, the law of succession, and statistical inference.
    square = QUANTILE_95**2 / count
    middle = (share + square / 2) / (1 + square)
    half = QUANTILE_95 * np.sqrt(share * (1 - share) / count + square / (4 * count)) / (1 + square)
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)


def is_settled(low: np.ndarray, high: np.ndarray, share: float, clear: np.ndarray) -> bool:
    """Return whether the edge of the safe area is known to a step of the grid."""
    # low, high (offsets, speeds); clear (offsets, speeds)
    sure, perhaps = (low >= share) & clear, (high >= share) & clear
    near = sure.copy()
    near[1:] |= sure[:-1]
    near[:-1] |= sure[1:]
    near[:, 1:] |= sure[:, :-1]
    near[:, :-1] |= sure[:, 1:]
    return not (perhaps & ~near).any()
