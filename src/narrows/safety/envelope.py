"""The safe envelope: how fast, and how far off the middle of a canal, a ship is still in hand."""

import math
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from narrows.errors import InputError
from narrows.model import Model
from narrows.physics.squat import KNOT
from narrows.safety.disturbance import Disturbance
from narrows.safety.equilibrium import check_rudder
from narrows.safety.keel import Keel, keel_at
from narrows.safety.trials import trials

RESERVE = 1 / 3
"""Of the rudder, to be left when the ship is steady."""
KEEL_SHARE = 0.05
"""Of the draft, to be left under the keel."""
MEDIAN, FIVE_PERCENT = 0.5, 0.95
"""Shares of draws that must be safe: the line of even odds, and the one that one draw in twenty may cross."""
OFFSETS, SPEEDS = 25, 15
SLOWEST, FASTEST = 0.3, 1.05
"""Of the speed that chokes the canal: the range where none is given."""
SQUARED = (
    "every force of these terms goes with the square of the speed, so the rudder that holds her is the same at any: "
    "what makes a fast ship harder to hold, beside squat and choking, is not in them"
)
SAME = 1e-6
"""Rudder angles [rad] that are one."""
CHOKED, AGROUND, RUDDER, HELM, RANGE, NONE = (
    "the canal chokes", "the keel", "the rudder", "the autopilot", "the range looked at", "no course holds her",
)  # fmt: skip
"""What ends the range of safe speeds."""


@dataclass(frozen=True)
class SafeEnvelope:
    """Where a ship is safe, and what the answer rests on.

    Parameters
    ----------
    data : xarray.Dataset
        Over y [m] and u [m/s]: ``rudder`` [rad] of the steady course, the median of the draws; ``rudder_95`` [rad], the
        size that 95 % of the draws stay within, infinite where more find no course; ``holds``, the share of draws that
        a steady course with the reserve exists for; ``held``, the share that the autopilot also holds; over u:
        ``clearance`` [m] under the keel and whether the keel is ``clear``.
    setting : str
        Ship and canal in words.
    notes : tuple of str
        What the answer rests on, and what it leaves out.
    """

    data: xr.Dataset
    setting: str
    notes: tuple[str, ...]

    def safe(self, share: float = FIVE_PERCENT) -> xr.DataArray:
        """Say at which offsets and speeds she is safe: keel clear, and held in at least a share of the draws.

        Parameters
        ----------
        share : float [1]
            Of the draws.
        """
        return (self.data["held"] >= share) & self.data["clear"]

    def highest_speed(self, share: float = FIVE_PERCENT) -> xr.DataArray:
        """Return the highest safe speed at each offset [m/s], NaN where there is none.

        It is the top of the lowest range of safe speeds: no faster one is counted across a gap.

        Parameters
        ----------
        share : float [1]
            Of the draws.
        """
        safe, speeds = self.safe(share).transpose("y", "u").to_numpy(), self.data["u"].to_numpy()
        tops = [_top(row) for row in safe]
        found = [math.nan if top is None else float(speeds[top]) for top in tops]
        return xr.DataArray(found, coords={"y": self.data["y"]}, dims="y", attrs={"units": "m/s"})

    def limited_by(self, share: float = FIVE_PERCENT) -> list[str]:
        """Say what ends the range of safe speeds at each offset.

        Parameters
        ----------
        share : float [1]
            Of the draws.
        """
        safe = self.safe(share).transpose("y", "u").to_numpy()
        return [self._reason(place, _top(row), share) for place, row in enumerate(safe)]

    def _reason(self, place: int, top: int | None, share: float) -> str:
        if top == self.data.sizes["u"] - 1:
            return RANGE
        next_up = self.data.isel(y=place, u=0 if top is None else top + 1)
        if not bool(next_up["clear"]):
            return CHOKED if math.isnan(float(next_up["clearance"])) else AGROUND
        if float(next_up["found"]) < share:
            return NONE
        return RUDDER if float(next_up["holds"]) < share else HELM

    def safest_offset(self, share: float = FIVE_PERCENT) -> xr.DataArray:
        """Return at each speed the offset [m] where she is safe and needs the least rudder, NaN where there is none.

        Parameters
        ----------
        share : float [1]
            Of the draws.
        """
        need = self.data["rudder_95"].where(self.safe(share), np.inf).transpose("u", "y").to_numpy()
        offsets = self.data["y"].to_numpy()
        found = [float(offsets[row.argmin()]) if np.isfinite(row).any() else math.nan for row in need]
        return xr.DataArray(found, coords={"u": self.data["u"]}, dims="u", attrs={"units": "m"})

    @property
    def speed_free(self) -> bool:
        """Whether the rudder that holds her is the same at every speed, as where all forces go with its square."""
        spread = np.ptp(self.data["rudder"].transpose("y", "u").to_numpy(), axis=1)
        return bool(np.nanmax(spread, initial=0.0) < SAME)

    @property
    def says(self) -> str:
        """The answer in one sentence."""
        top = self.highest_speed()
        if top.isnull().all():
            return "At no offset and speed is she held in 95 % of the draws with the rudder and the keel in reserve."
        most = float(top.max())
        wide = top["y"].to_numpy()[top.to_numpy() >= most]
        return (
            f"Safe up to {most / KNOT:.1f} knots between {wide.min():+.1f} and {wide.max():+.1f} m off the middle "
            "(starboard is positive), in 95 % of the draws."
        )


def _top(safe: np.ndarray) -> int | None:
    """Last of the first run of safe speeds."""
    if not safe.any():
        return None
    first = int(safe.argmax())
    after = np.flatnonzero(~safe[first:])
    return first + int(after[0]) - 1 if after.size else len(safe) - 1


def safe_envelope(
    model: Model, y: np.ndarray | None = None, u: np.ndarray | None = None, *,
    disturbance: Disturbance | None = None, reserve: float = RESERVE, keel: float | None = None, draws: int = 200,
    seed: int = 0, workers: int | None = None, progress: bool = False,
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
    draws : int
        Of coefficients and disturbances.
    seed : int
        Of the draws.
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
    if not 0 <= reserve < 1:
        raise InputError(f"a reserve of {reserve} is no share of the rudder; give one from 0 to less than 1")
    offsets = _offsets(model) if y is None else np.atleast_1d(np.asarray(y, float))
    speeds = _speeds(model) if u is None else np.atleast_1d(np.asarray(u, float))
    _check(offsets, speeds)
    setting = model.setting
    under = keel_at(setting, speeds)
    least = KEEL_SHARE * setting.ship.draft if keel is None else keel
    tried = trials(model, offsets, speeds, under.midship, disturbance or Disturbance(), draws, seed, workers, progress)
    data = _summed(tried, (1 - reserve) * setting.gear.limit)
    clear = ((under.clearance >= least) | (setting.canal.depth is None)) & (speeds < under.choke)
    data = data.assign(clearance=("u", under.clearance, {"units": "m"}), clear=("u", clear))
    data["y"].attrs, data["u"].attrs = {"units": "m"}, {"units": "m/s"}
    found = SafeEnvelope(data, _in_words(model), _notes(model, under, least))
    return replace(found, notes=(*found.notes, SQUARED)) if found.speed_free and len(speeds) > 1 else found


def _summed(tried: xr.Dataset, limit: float) -> xr.Dataset:
    """Draws as shares and quantiles."""
    size = np.abs(tried["rudder"]).fillna(np.inf)
    holds = size <= limit
    with np.errstate(invalid="ignore"):
        quantile = size.quantile(FIVE_PERCENT, "draw", method="higher").drop_vars("quantile")
    return xr.Dataset(
        {
            "rudder": _median(tried["rudder"]).assign_attrs(units="rad"),
            "rudder_95": quantile.assign_attrs(units="rad"),
            "found": np.isfinite(tried["rudder"]).mean("draw"),
            "holds": holds.mean("draw"),
            "held": (holds & tried["held"]).mean("draw"),
        }
    )


def _median(rudder: xr.DataArray) -> xr.DataArray:
    """Median of the draws, those without a course counted as hard over and beyond; NaN where they are the half."""
    beyond = np.sign(rudder.median("draw")).fillna(1.0) * np.inf
    found = rudder.fillna(beyond).quantile(MEDIAN, "draw", method="lower").drop_vars("quantile")
    return found.where(np.isfinite(found))


def _offsets(model: Model) -> np.ndarray:
    room = model.setting.canal.width / 2 - model.setting.ship.beam
    if room <= 0:
        raise InputError("the canal is less than two beams wide: there is no offset to look at; check its width")
    return np.linspace(-room, room, OFFSETS)


def _speeds(model: Model) -> np.ndarray:
    choke = keel_at(model.setting, np.empty(0)).choke
    if math.isinf(choke):
        raise InputError("without a depth nothing bounds the speed: give the canal's depth, or the speeds to look at")
    return np.linspace(SLOWEST, FASTEST, SPEEDS) * choke


def _check(offsets: np.ndarray, speeds: np.ndarray) -> None:
    for name, column in (("offsets", offsets), ("speeds", speeds)):
        if not column.size or not np.isfinite(column).all() or (np.diff(column) <= 0).any():
            raise InputError(f"the {name} must be finite and rise; give them in order, none twice")
    if speeds[0] <= 0:
        raise InputError(f"a speed of {speeds[0]:g} m/s steers nothing; give speeds over 0")


def _in_words(model: Model) -> str:
    ship, canal = model.setting.ship, model.setting.canal
    deep = "of unknown depth" if canal.depth is None else f"{canal.depth:.4g} m deep"
    size = f"{ship.length:.4g} x {ship.beam:.4g} x {ship.draft:.4g} m"
    return f"{ship.name}, {size}, in a canal {canal.width:.4g} m wide, {deep}"


def _notes(model: Model, under: Keel, least: float) -> tuple[str, ...]:
    notes = [*under.notes]
    if model.covariance is None:
        notes.append("no covariance of the coefficients is known: the draws are of disturbances alone")
    if model.setting.canal.depth is not None:
        notes.append(f"{least:.2g} m are to be left under the keel")
    gear = model.setting.gear
    notes.append(f"rudder to {gear.limit_deg:.3g} degrees at {gear.rate_deg:.3g} degrees a second")
    notes.append(
        "the speed is held: what the propeller can give, and what it does to the rudder when it changes, is not asked"
    )
    return tuple(notes)
