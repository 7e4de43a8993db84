"""Trials of many samples as shares and quantiles, and as many samples as settle the edge."""

from collections.abc import Callable

import numpy as np
import xarray as xr

from narrows.safety.answer import MEDIAN, SURE_SHARE
from narrows.safety.sampling import is_settled, share_interval

# Tried at first where no number is given, and doubled until the edge is settled, up to so many.
FIRST_SAMPLES, MOST_SAMPLES = 400, 6400
# Trials of so many ``samples`` from a ``seed``, over y, u and sample.
Trial = Callable[..., xr.Dataset]


def settled_trials(try_more: Trial, samples: int | None, seed: int, limit: float, clear: np.ndarray) -> xr.Dataset:
    """Return trials of so many samples, or of twice as many again and again until the edge is settled."""
    # limit [rad]; clear (offsets, speeds)
    if samples is not None:
        return try_more(samples=samples, seed=seed)
    tried, rounds = try_more(samples=FIRST_SAMPLES, seed=seed), 0
    while (count := tried.sizes["sample"]) < MOST_SAMPLES:
        held = safely(tried, limit, "held").mean("sample").transpose("y", "u").to_numpy()
        if is_settled(*share_interval(held, count), SURE_SHARE, clear):
            break
        rounds += 1
        another = int(np.random.SeedSequence((seed, rounds)).generate_state(1)[0])
        tried = xr.concat([tried, try_more(samples=count, seed=another)], "sample")
    return tried


def shares_of(tried: xr.Dataset, limit: float) -> xr.Dataset:
    """Return shares and quantiles of the samples over y and u."""
    # tried [rad]; limit [rad]
    # A sample without a course counts as beyond hard over, on the side of the others.
    found, holds = np.isfinite(tried["rudder"]), np.abs(tried["rudder"]) <= limit
    shares = {"found": found.mean("sample"), "holds": holds.mean("sample")}
    for name in ("held", "known"):
        shares |= _counted(name, safely(tried, limit, name))
    counted = {name: share.assign_attrs(units="1") for name, share in shares.items()}
    return xr.Dataset(_quantiles(tried["rudder"]) | counted).transpose("y", "u")


def safely(tried: xr.Dataset, limit: float, name: str) -> xr.DataArray:
    """Return in which trials a ship is held on a course that leaves the reserve."""
    # limit [rad]
    return (np.abs(tried["rudder"]) <= limit) & tried[name]


def likely_shares(tried: xr.Dataset, limit: float) -> dict[str, xr.DataArray]:
    """Return what the ship of the most likely coefficients says, over y and u: ``certain``, ``rudder_likely``."""
    # limit [rad]
    share = safely(tried, limit, "known").mean("sample").assign_attrs(units="1")
    return {"certain": share, "rudder_likely": tried["rudder"].isel(sample=0).assign_attrs(units="rad")}


def _counted(name: str, counted: xr.DataArray) -> dict[str, xr.DataArray]:
    """The share of the samples in which something holds, and its interval for so many of them."""
    share = counted.mean("sample")
    low, high = (share.copy(data=end) for end in share_interval(share.to_numpy(), counted.sizes["sample"]))
    return {name: share, f"{name}_low": low, f"{name}_high": high}


def _quantiles(rudder: xr.DataArray) -> dict[str, xr.DataArray]:
    beyond = np.sign(rudder.median("sample")).fillna(1.0) * np.inf
    filled, size = rudder.fillna(beyond.where(beyond != 0, np.inf)), np.abs(rudder).fillna(np.inf)
    middle = _quantile(filled, MEDIAN, "midpoint")
    return {
        "rudder": middle.where(np.isfinite(middle)).assign_attrs(units="rad"),
        "rudder_low": _quantile(filled, 1 - SURE_SHARE, "lower"),
        "rudder_high": _quantile(filled, SURE_SHARE, "higher"),
        "rudder_95": _quantile(size, SURE_SHARE, "higher"),
    }


def _quantile(values: xr.DataArray, share: float, method: str) -> xr.DataArray:
    with np.errstate(invalid="ignore"):
        quantiles = values.quantile(share, "sample", method=method).drop_vars("quantile")
    return quantiles.assign_attrs(units="rad")
