"""Offsets and speeds at which a ship may be held: the rudder leaves its reserve, side and keel their clearance."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from narrows.control.steady_course import steady_course
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.safety.question import KEEL_SHARE, keel_at

# Of offsets to either side about, and what one is a power of ten times.
STEPS, NICE = 20, (1.0, 2.0, 2.5, 5.0, 10.0)
# Of the speed that chokes the canal, between which speeds are looked at where none are given, and how many.
SLOW, FAST, SPEEDS = 0.35, 0.7, 3
# Shares of the samples, below which angles are told.
TOLD = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class Candidates:
    """Steady courses at offsets and speeds."""

    offsets: np.ndarray  # (places,) To starboard or in the middle [m]
    speeds: np.ndarray  # (places,) Through the water [m/s]
    rudder: np.ndarray  # (places,) Of the most likely coefficients [rad]
    psi: np.ndarray  # (places,) Of the most likely coefficients [rad]
    # (places, 3) Of the samples: what 5 %, half and 95 % are below, infinite where there is no course [rad]
    rudder_told: np.ndarray
    # (places, 3) Of the samples: what 5 %, half and 95 % are below, infinite where there is no course [rad]
    psi_told: np.ndarray
    within: np.ndarray  # (places,) Share of the samples that leave the rudder its reserve [1]
    clear: np.ndarray  # (places,) Whether side and keel have their clearance

    def allowed(self, share: float) -> np.ndarray:
        """Return at which places a ship may be held, (places,) of bool."""
        return np.asarray(self.clear & (self.within >= share) & np.isfinite(self.rudder))


def usual_offsets(model: Model, clearance: float) -> np.ndarray:
    """Return offsets to starboard that leave a clearance, in round steps, (n,) [m]."""
    # clearance [m]
    room = (model.configuration.canal.width - model.configuration.ship.beam) / 2 - clearance
    if room <= 0:
        raise InputError(f"a clearance of {clearance:g} m leaves no offset in this canal; give less")
    power = 10.0 ** math.floor(math.log10(room / STEPS))
    step = next(nice * power for nice in NICE if nice * power >= room / STEPS)
    return np.asarray(step * np.arange(1, math.floor(room / step) + 1))


def usual_speeds(model: Model) -> np.ndarray:
    """Return speeds that a canal lets a ship go, within those of its tests, (n,) [m/s]."""
    choke, covered = keel_at(model, np.empty(0)).choke, model.data_range.speed
    if math.isinf(choke) and covered is None:
        raise InputError("neither a depth nor the tests bound the speed; give the speeds to look at")
    low, high = (SLOW * choke, FAST * choke) if math.isfinite(choke) else covered or (0.0, 0.0)
    if covered and max(low, covered[0]) < min(high, covered[1]):
        low, high = max(low, covered[0]), min(high, covered[1])
    # In the second digit of knots, that a bridge can steer for.
    speeds = np.linspace(low, high, SPEEDS) / KNOT
    digit = 10.0 ** (math.floor(math.log10(high / KNOT)) - 1)
    return np.unique(np.floor(speeds / digit + 0.5) * digit) * KNOT


def candidates(
    model: Model, offsets: np.ndarray, speeds: np.ndarray, reserve: float, clearance: float, samples: int, seed: int
) -> Candidates:
    """Find the steady courses at offsets and speeds, and whether a ship may be held there.

    Parameters
    ----------
    model : Model
        With a covariance.
    offsets : array (n,) [m]
        To starboard of the middle, or 0.
    speeds : array (m,) [m/s]
        Through the water.
    reserve : float [1]
        Of the rudder, to be left.
    clearance : float [m]
        From the hull's side to a bank, to be left.
    samples : int
        Of the coefficients.
    seed : int
        Of the samples.
    """
    y, u = (part.ravel() for part in np.meshgrid(offsets, speeds, indexing="ij"))
    keel = keel_at(model, u)
    felt = {name: xr.DataArray(part, dims="place") for name, part in {"y": y, "u": u, "heave": keel.midship}.items()}
    mean = steady_course(model, **felt)
    drawn = steady_course(model, samples=samples, seed=seed, **felt).transpose("place", "sample")
    rudder, psi = (np.nan_to_num(drawn[name].to_numpy(), nan=np.inf) for name in ("rudder", "psi"))
    gear, ship, canal = model.configuration.gear, model.configuration.ship, model.configuration.canal
    turned = ship.length / 2 * np.abs(np.sin(mean["psi"].to_numpy()))
    beside = canal.width / 2 - np.abs(y) - ship.beam / 2 - turned >= clearance
    unknown = np.isnan(keel.clearance) & (canal.depth is None)
    under = (unknown | (keel.clearance >= KEEL_SHARE * ship.draft)) & (u < keel.choke)
    rudder_told, psi_told = (np.quantile(part, TOLD, axis=1, method="higher").T for part in (rudder, psi))
    within = (np.abs(rudder) <= (1 - reserve) * gear.limit).mean(axis=1)
    likely, clear = (mean["rudder"].to_numpy(), mean["psi"].to_numpy()), beside & under
    return Candidates(y, u, *likely, rudder_told, psi_told, within, clear)
