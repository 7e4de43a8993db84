"""A beam wind on a ship of which only the length is known, as an assumption of legs and transits."""

from dataclasses import dataclass, fields

import numpy as np

from narrows.errors import InputError, shown
from narrows.logbook.settings import WIND_LEVER, WINDAGE
from narrows.model.model import Model
from narrows.results import BaseSummary
from narrows.safety.request import wind_force
from narrows.ship.checks import is_finite


@dataclass(frozen=True, repr=False)
class BeamWind(BaseSummary):
    """Standard deviations of a beam wind, for conditions with further fields."""

    wind: float = 8.0
    windage: float | None = None
    wind_lever: float | None = None

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, least = getattr(self, entry.name), "over" if entry.name.endswith("_time") else "from"
            missing = value is None and entry.default is None
            if not missing and (not is_finite(value) or value < 0 or (least == "over" and value == 0)):
                raise InputError(
                    f"{type(self).__name__}: {entry.name} = {shown(value)}: give a finite number {least} 0"
                )

    def steady_push(self, model: Model) -> np.ndarray:
        """Return sway force [N] and yaw moment [N m] of the wind, (2,).

        Parameters
        ----------
        model : Model
            The ship.
        """
        length = model.configuration.ship.length
        force = wind_force(self.wind, WINDAGE * length**2 if self.windage is None else self.windage)
        return np.array([force, force * (WIND_LEVER * length if self.wind_lever is None else self.wind_lever)])
