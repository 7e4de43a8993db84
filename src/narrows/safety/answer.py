"""The answer to where a ship is safe: speeds by offset, offsets by speed, and what limits them."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from narrows.quantities.constants import KNOT

MEDIAN, FIVE_PERCENT = 0.5, 0.95
"""Shares of samples that must be safe: the line of even odds, and the one that one sample in twenty may cross."""
SAME, TURNED = 1e-6, 1e-4
"""Rudder angles [rad] that are one, and the least that says something."""
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
        Over y [m] and u [m/s]: ``rudder`` [rad] of the steady course, the median of the samples; ``rudder_low`` and
        ``rudder_high`` [rad], that 90 % of the samples are between; ``rudder_95`` [rad], the size that 95 % stay
        within, infinite where more find no course; ``found``, the share with a course; ``holds``, the share whose
        course leaves the reserve; ``held``, the share that the autopilot also holds; over u: ``clearance`` [m] under
        the keel and whether the keel is ``clear``. Its attributes are ship and canal, the notes, and where a keel meets
        the banks [m].
    """

    data: xr.Dataset

    @property
    def description(self) -> str:
        """Ship and canal in words."""
        return str(self.data.attrs["setting"])

    @property
    def notes(self) -> tuple[str, ...]:
        """What the answer rests on, and what it leaves out."""
        return tuple(str(self.data.attrs["notes"]).splitlines())

    @property
    def walls(self) -> tuple[float, float]:
        """Where her keel meets the banks [m], to port and to starboard of the middle."""
        return float(self.data.attrs["wall_port"]), float(self.data.attrs["wall_starboard"])

    def noting(self, note: str) -> "SafeEnvelope":
        """Return the answer with a note before its own.

        Parameters
        ----------
        note : str
            In one line.
        """
        return SafeEnvelope(self.data.assign_attrs(notes="\n".join((note, *self.notes))))

    def safe(self, share: float = FIVE_PERCENT) -> xr.DataArray:
        """Say at which offsets and speeds she is safe: keel clear, and held in at least a share of the samples.

        Parameters
        ----------
        share : float [1]
            Of the samples.
        """
        return (self.data["held"] >= share) & self.data["clear"]

    def highest_speed(self, share: float = FIVE_PERCENT) -> xr.DataArray:
        """Return the highest safe speed at each offset [m/s], NaN where there is none.

        It is the top of the lowest range of safe speeds: no faster one is counted across a gap.

        Parameters
        ----------
        share : float [1]
            Of the samples.
        """
        return self._speeds(share, 1)

    def lowest_speed(self, share: float = FIVE_PERCENT) -> xr.DataArray:
        """Return the lowest safe speed at each offset [m/s], NaN where there is none: below it gusts may win.

        Parameters
        ----------
        share : float [1]
            Of the samples.
        """
        return self._speeds(share, 0)

    def limited_by(self, share: float = FIVE_PERCENT) -> list[str]:
        """Say what ends the range of safe speeds at each offset.

        Parameters
        ----------
        share : float [1]
            Of the samples.
        """
        return [self._reason(place, ends, share) for place, ends in enumerate(self._ends(share))]

    def safest_offset(self, share: float = FIVE_PERCENT) -> xr.DataArray:
        """Return at each speed the offset [m] where she is safe and needs the least rudder, NaN where there is none.

        Parameters
        ----------
        share : float [1]
            Of the samples.
        """
        need = self.data["rudder_95"].where(self.safe(share), np.inf).transpose("u", "y").to_numpy()
        offsets = self.data["y"].to_numpy()
        found = [float(offsets[row.argmin()]) if np.isfinite(row).any() else math.nan for row in need]
        return xr.DataArray(found, coords={"u": self.data["u"]}, dims="u", attrs={"units": "m"})

    @property
    def speed_free(self) -> bool:
        """Whether the rudder that holds her is the same at every speed, as where all forces go with its square."""
        rudder = self.data["rudder"].transpose("y", "u").to_numpy()
        telling = rudder[np.isfinite(rudder).all(axis=1) & (np.abs(rudder) > TURNED).all(axis=1)]
        return rudder.shape[1] > 1 and len(telling) > 0 and bool(np.ptp(telling, axis=1).max() < SAME)

    @property
    def says(self) -> str:
        """The answer in one sentence."""
        top, bottom = self.highest_speed().to_numpy(), self.lowest_speed().to_numpy()
        if np.isnan(top).all():
            return "At no offset and speed is she held in 95 % of the samples with the rudder and the keel in reserve."
        best = int(np.nanargmax(top - bottom + 1e-9 * (top == np.nanmax(top))))
        offsets, alike = self.data["y"].to_numpy(), (top == top[best]) & (bottom == bottom[best])
        first, last = best, best
        while first > 0 and alike[first - 1]:
            first -= 1
        while last < len(alike) - 1 and alike[last + 1]:
            last += 1
        return (
            f"Safe from {bottom[best] / KNOT:.1f} to {top[best] / KNOT:.1f} knots between {offsets[first]:+.1f} and "
            f"{offsets[last]:+.1f} m off the middle (starboard is positive), in 95 % of the samples."
        )

    def _ends(self, share: float) -> list[tuple[int, int] | None]:
        return [_first_run(row) for row in self.safe(share).transpose("y", "u").to_numpy()]

    def _speeds(self, share: float, end: int) -> xr.DataArray:
        speeds = self.data["u"].to_numpy()
        found = [math.nan if ends is None else float(speeds[ends[end]]) for ends in self._ends(share)]
        return xr.DataArray(found, coords={"y": self.data["y"]}, dims="y", attrs={"units": "m/s"})

    def _reason(self, place: int, ends: tuple[int, int] | None, share: float) -> str:
        if ends is not None and ends[1] == self.data.sizes["u"] - 1:
            return RANGE
        next_up = self.data.isel(y=place, u=0 if ends is None else ends[1] + 1)
        if not bool(next_up["clear"]):
            return CHOKED if math.isnan(float(next_up["clearance"])) else AGROUND
        if float(next_up["found"]) < share:
            return NONE
        return RUDDER if float(next_up["holds"]) < share else HELM


def _first_run(safe: np.ndarray) -> tuple[int, int] | None:
    """First and last of the first run of safe speeds."""
    if not safe.any():
        return None
    first = int(safe.argmax())
    after = np.flatnonzero(~safe[first:])
    return first, first + int(after[0]) - 1 if after.size else len(safe) - 1
