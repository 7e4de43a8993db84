"""A beam wind on a ship of which only the length is known, as an assumption of legs and transits."""

from dataclasses import dataclass

import numpy as np

from narrows.logbook.sensor_grades import check_sizes
from narrows.logbook.settings import WIND_LEVER, WINDAGE
from narrows.model.model import Model
from narrows.results import BaseSummary
from narrows.safety.request import wind_force


@dataclass(frozen=True, repr=False)
class BeamWind(BaseSummary):
    """Standard deviations of a beam wind, for conditions with further fields."""

    wind: float = 8.0
    windage: float | None = None
    wind_lever: float | None = None

    def __post_init__(self) -> None:
        check_sizes(self, over=[name for name in vars(self) if name.endswith("_time")])

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
