"""Change of the safe envelope by a record: the same places with the model before and the model after."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.aliases import accept_aliases
from narrows.control.steady_course import steady_course
from narrows.logbook.learned_coefficient import ON_TWINS
from narrows.logbook.settings import CHANGE_OFFSETS, CHANGE_SAMPLES, CHANGE_SPEEDS, RUDDER_BAND
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.results import BaseResult
from narrows.safety.envelope import safe_envelope
from narrows.safety.result import SafeEnvelope

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class EnvelopeChange(BaseResult):
    """The safe envelope before a record and after it.

    Parameters
    ----------
    before, after : SafeEnvelope
        At the same offsets and speeds, against the same disturbances.
    rudder_before, rudder_after : array (offsets, 3) [rad]
        Rudder of the steady course at the middle of the speeds: 5 %, 50 % and 95 % quantiles of the samples; infinite
        where no rudder holds them.
    """

    before: SafeEnvelope
    after: SafeEnvelope
    rudder_before: np.ndarray
    rudder_after: np.ndarray

    @property
    def notes(self) -> tuple[str, ...]:
        """Number of cases, and the label of results from twins."""
        return f"{self.before.samples} cases at each place: a look; narrows envelope settles the edges.", ON_TWINS

    def summary(self) -> str:
        """Safe area before, and now."""
        return f"Before: {self.before.summary()}\nAfter: {self.after.summary()}"

    def rows(self) -> list[dict[Any, Any]]:
        """Give a row an offset [m]: at the middle speed rudder [deg] and share held, and the highest speed [knots]."""
        return self.to_dataframe().reset_index().to_dict("records")

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the rows as a table."""
        import pandas as pd

        data = self.before.data
        middle = data.sizes["u"] // 2
        table = {"offset": data["y"].to_numpy(), "speed": float(data["u"][middle]) / KNOT}
        for when, angles in (("before", self.rudder_before), ("after", self.rudder_after)):
            names = (f"rudder_{name}_{when}" for name in ("low", "median", "high"))
            table |= dict(zip(names, np.degrees(angles).T, strict=True))
        for when, envelope in (("before", self.before), ("after", self.after)):
            table[f"held_{when}"] = envelope.data["held"].isel(u=middle).to_numpy()
            # The highest speed that the model has safe at each offset, tested or not; NaN where there is none.
            safe = envelope.by_model().transpose("y", "u").to_numpy()
            speeds = pd.DataFrame(np.where(safe, envelope.data["u"].to_numpy() / KNOT, np.nan))
            table[f"highest_speed_{when}"] = speeds.max(axis=1).to_numpy()
        return pd.DataFrame(table).set_index("offset")

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name: part of what ``learn --json`` prints."""
        found = {"samples": self.before.samples, "offsets": self.rows()}
        return {"summary": self.summary(), **found, "notes": list(self.notes)}


@accept_aliases
def envelope_change(
    before: Model, after: Model, y: Sequence[float] | np.ndarray, u: Sequence[float] | np.ndarray, *,
    samples: int = CHANGE_SAMPLES, seed: int = 0, **envelope: Any,
) -> EnvelopeChange:  # fmt: skip
    """Ask the same safe envelope of a model before a record and after it.

    Parameters
    ----------
    before, after : Model
        The ship in one canal.
    y, u : sequence of float [m], [m/s]
        Offsets to starboard of the middle and speeds through the water, rising.
    samples, seed : int
        Number and seed of the samples of coefficients and disturbances.
    **envelope : Any
        As for ``safe_envelope``.
    """
    offsets, speeds = np.asarray(y, float), np.asarray(u, float)
    found = [safe_envelope(model, offsets, speeds, samples=samples, seed=seed, **envelope) for model in (before, after)]
    angles = [rudder_band(model, offsets, float(speeds[len(speeds) // 2]), samples, seed) for model in (before, after)]
    return EnvelopeChange(found[0], found[1], angles[0], angles[1])


def places_of(y: np.ndarray, u: np.ndarray, room: float) -> tuple[np.ndarray, np.ndarray]:
    # y (n,) [m]; u (n,) [m/s]; room [m]
    far = float(np.abs(y).max()) or room / 4
    offsets = far * np.array(CHANGE_OFFSETS)
    return offsets[offsets < room], float(u.mean()) * np.array(CHANGE_SPEEDS)


def rudder_band(model: Model, y: np.ndarray, u: float, samples: int = CHANGE_SAMPLES, seed: int = 0) -> np.ndarray:
    """Return the rudder of steady courses that 5 %, half and 95 % of the samples stay below [rad], (offsets, 3)."""
    # y (offsets,) [m]; u [m/s]
    rudder = steady_course(model, y=xr.DataArray(y, dims="place"), u=u, samples=samples, seed=seed)["rudder"]
    angles = rudder.transpose("place", "sample").to_numpy()
    # Where none holds it, it is the bow's turning away from the near bank that outgrew the rudder.
    beyond = np.where(np.asarray(y) < 0, -np.inf, np.inf)[:, None]
    ordered = np.where(np.isnan(angles), beyond, angles)
    low, high = RUDDER_BAND
    return np.asarray(np.quantile(ordered, (low, 0.5, high), axis=1, method="higher").T)
