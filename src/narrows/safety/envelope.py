"""The safe envelope: how fast, and how far off the centreline, a ship stays controllable."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from narrows.base.aliases import accept_aliases
from narrows.base.errors import check_choice
from narrows.control.steady_course import check_rudder
from narrows.model.model import Model
from narrows.safety import settings
from narrows.safety.channel_rules import BANKS
from narrows.safety.pilots import PILOTS, Pilot
from narrows.safety.request import Bend, Disturbance, EnvelopeRequest, Keel, Walls, envelope_request, keel_at
from narrows.safety.result import MEDIAN, SafeEnvelope, data_coverage, with_caveats
from narrows.safety.trials import trials
from narrows.simulation.inputs import check_workers, finite_numbers


@accept_aliases
def safe_envelope(
    model: Model, y: np.ndarray | None = None, u: np.ndarray | None = None, *,
    disturbance: Disturbance | None = None, reserve: float = settings.RESERVE, keel: float | None = None,
    samples: int = settings.SAMPLES, seed: int = 0, walls: Walls | None = None, bank: str = "steep",
    controller: str = "regulator", curvature: float = 0.0, current: float = 0.0, workers: int | None = None,
    progress: bool = False,
) -> SafeEnvelope:  # fmt: skip
    """Find the speeds and offsets at which a ship stays controllable in its canal.

    At each offset and speed it computes the steady course: rudder, heading and drift in equilibrium. The ship is safe
    there if that course leaves a reserve of rudder, a pilot with the real gear and without the true coefficients holds
    it against disturbances, the keel is clear and the canal is not choked. The result also shows where a pilot with the
    true coefficients holds it. Coefficients are drawn from the covariance of the fit.

    Raises an InputError if the model has no rudder, a number is out of range, or speeds, bank or pilot are unknown.

    Parameters
    ----------
    model : Model
        A model at the ship's own size, with the terms of a rudder.
    y, u : array (offsets,) [m], array (speeds,) [m/s], optional
        Offsets to starboard of the middle, by default up to half a beam from either bank; speeds through the water, by
        default to a little over the choking speed.
    disturbance : Disturbance, optional
        Initial deviations and gusts.
    reserve, keel : float [1], float [m], optional
        Share of the rudder left on the steady course; least clearance under the keel, default a twentieth of the draft.
    samples, seed : int
        Number of samples of coefficients and disturbances; the answer names what they leave uncertain.
    walls : pair of float [m], optional
        Places where the keel meets the banks, to port and to starboard of the middle; default: the canal's walls.
    bank : str
        Kind of bank for the comparison with outside rules: ``gentle``, ``sloping`` or ``steep``.
    controller : str
        Pilot without the true coefficients: ``regulator``, or ``human``, with delay, whole degrees and a limit.
    curvature, current : float [1/m], float [m/s]
        Curvature of the canal, to starboard: in a bend the steady turn leaves the reserve, and trials sail it; the
        current along it, with the ship.
    workers, progress : int, bool
        As for ``ensemble``.
    """
    check_rudder(model)
    check_workers(workers)
    check_choice("bank", bank, BANKS)
    check_choice("controller", controller, PILOTS)
    request = envelope_request(
        model, y, u, keel=keel, walls=walls, disturbance=disturbance or Disturbance(), reserve=reserve,
        bank=bank, pilot=controller,
        bend=Bend(**finite_numbers(curvature=curvature, current=current)),
    )  # fmt: skip
    under = keel_at(model, request.speeds)
    bounds = bounds_of(request, under)
    try_more = partial(
        trials, y=request.offsets, u=request.speeds, heave=under.midship, disturbance=request.disturbance,
        walls=request.walls, bend=request.bend, workers=workers, progress=progress,
        pilot=choose_pilot(request, under.midship, bounds["clear"].to_numpy(), seed, workers),
    )  # fmt: skip
    tried = try_more(model, samples=samples, seed=seed)
    likely = tried
    if model.covariance is not None:
        likely = try_more(replace(model, covariance=None), samples=settings.LIKELY_SAMPLES, seed=seed)
    limit = request.rudder_limit
    found = {**controllable_fraction(tried, limit), **best_estimate_fraction(likely, limit)}
    data = xr.Dataset(found).transpose("y", "u").assign(bounds.data_vars)
    data["y"].attrs, data["u"].attrs = {"units": "m"}, {"units": "m/s"}
    return with_caveats(data, request, under, tried.sizes["sample"])


def bounds_of(request: EnvelopeRequest, under: Keel) -> xr.Dataset:
    """Return the clearance of the keel, where keel and canal are clear, and what the tests covered."""
    model, speeds = request.model, request.speeds
    floating = (under.clearance >= request.clearance) | (model.configuration.canal.depth is None)
    return xr.Dataset({
        "clearance": ("u", under.clearance, {"units": "m"}),
        "clear": ("u", floating & (speeds < under.choke)),
        "tested": (("y", "u"), data_coverage(model, request.offsets, speeds)),
    })  # fmt: skip


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

    def share(tuned: Pilot) -> float:
        tried = trials(
            request.model, request.offsets[offsets], request.speeds[speeds], heave[speeds],
            request.disturbance, settings.TUNING_SAMPLES, other_seed, request.walls, tuned,
            bend=request.bend, knowing=False, workers=workers,
        )  # fmt: skip
        return float(safely(tried, request.rudder_limit, "held").mean())

    return max((replace(pilot, tunings=(tuning,)) for tuning in pilot.tunings), key=share)


def _spread(size: int, most: int) -> np.ndarray:
    """Return at most ``most`` places of a row, evenly spaced, without its ends if there are more."""
    if size <= most:
        return np.arange(size)
    return np.unique(np.round((np.arange(most) + 0.5) * size / most - 0.5).astype(int))


def controllable_fraction(tried: xr.Dataset, limit: float) -> dict[str, xr.DataArray]:
    # tried [rad]; limit [rad]. A sample without a course counts as beyond hard over, on the side of the others.
    rudder, count = tried["rudder"], tried.sizes["sample"]
    shares = {"found": np.isfinite(rudder).mean("sample"), "holds": (np.abs(rudder) <= limit).mean("sample")}
    shares |= {name: safely(tried, limit, name).mean("sample") for name in ("held", "known")}
    for end, column in zip(("low", "high"), share_interval(shares["held"].to_numpy(), count), strict=True):
        shares[f"held_{end}"] = shares["held"].copy(data=column)
    filled = rudder.fillna(xr.where(rudder.median("sample") < 0, -np.inf, np.inf))
    middle = _quantile(filled, MEDIAN, "midpoint")
    angles = {
        "rudder": middle.where(np.isfinite(middle)),
        "rudder_low": _quantile(filled, 1 - settings.SURE_SHARE, "lower"),
        "rudder_high": _quantile(filled, settings.SURE_SHARE, "higher"),
        "rudder_95": _quantile(np.abs(rudder).fillna(np.inf), settings.SURE_SHARE, "higher"),
    }
    units = {**dict.fromkeys(angles, "rad"), **dict.fromkeys(shares, "1")}
    return {name: column.assign_attrs(units=units[name]) for name, column in {**angles, **shares}.items()}


def _quantile(values: xr.DataArray, share: float, method: Any) -> xr.DataArray:
    with np.errstate(invalid="ignore"):
        return values.quantile(share, "sample", method=method).drop_vars("quantile")


def safely(tried: xr.Dataset, limit: float, name: str) -> xr.DataArray:
    return (np.abs(tried["rudder"]) <= limit) & tried[name]


def best_estimate_fraction(tried: xr.Dataset, limit: float) -> dict[str, xr.DataArray]:
    """Return the results for the best estimate, over y and u: ``certain``, ``rudder_likely``."""
    share = safely(tried, limit, "known").mean("sample").assign_attrs(units="1")
    # A steady wind may blow from either side: the larger rudder counts, and none where one side has no course.
    most, least = (getattr(tried["rudder"], of)("sample", skipna=False) for of in ("max", "min"))
    return {"certain": share, "rudder_likely": xr.where(abs(most) >= abs(least), most, least).assign_attrs(units="rad")}


# Standard deviations of a two-sided 95 % interval of a normal distribution.
QUANTILE_95 = 1.959964


def share_interval(share: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the 95 % interval of a counted share, low and high [1]."""
    # Wilson (1927), Probable inference, the law of succession, and statistical inference.
    square = QUANTILE_95**2 / count
    middle = (share + square / 2) / (1 + square)
    half = QUANTILE_95 * np.sqrt(share * (1 - share) / count + square / (4 * count)) / (1 + square)
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
