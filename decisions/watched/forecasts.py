"""What is foretold of many ships at once: by the package's forecaster, and by what bridges have today."""

import math

import numpy as np

import narrows as nw
from narrows.estimation.estimator import Estimator
from narrows.estimation.unscented import Gaussian
from narrows.warning.forecasting.forecast import AFTER, CASES, CHANCES, LIKELY
from narrows.warning.forecasting.forecaster import BridgePredictor, Forecaster, Samples
from narrows.warning.forecasting.future_lanes import FutureBlock, FutureLanes
from narrows.warning.settings import SOON
from watched.truths import SPEED, WIDTH, modelled

STEP, ALARMING = 2.5, 120.0
"""Of the motion [s], as the forecaster takes it; contact of the likely run, up to which its last chance is sought."""
AT_ONCE, SCOUTS = 8, 16
"""Ships that are looked at closely in one call; members that are sailed first: where none of them meets a bank in any
way, the chances are taken for 0, and the others stay at home."""
COLUMNS = ("room", "line", "curve", "contact", "last_chance", "pilot_now", "soon", "later")
"""Clearance [m]; time to contact straight on, curved, of the likely run [s]; its last chance, 0 where that is gone [s];
chance of contact with a pilot now, within 60 s and within 120 s with the rudder as it is."""


class ForecastsAbreast:
    """Forecasts of ships in a straight canal, for a pilot who keeps to the middle.

    Parameters
    ----------
    estimator : Estimator
        As the ships' filters are.
    count, members : int
        Ships, and members of each ensemble.
    """

    def __init__(self, estimator: Estimator, count: int, members: int) -> None:
        self.count, self.forecaster = count, Forecaster(estimator, members=members)
        self.members = self.forecaster._members
        half, few = members // 2, min(SCOUTS, members) // 2
        self.scouts = np.r_[:few, half : half + few]
        filter, pilot = self.forecaster.filter, nw.control.regulator(estimator.filter.model, 0.0, SPEED)

        def lanes(*blocks: FutureBlock) -> FutureLanes:
            return FutureLanes(filter.ship, None, pilot, blocks, STEP)

        both = CASES[:2]
        self.first = lanes(FutureBlock(both, count * len(self.scouts)), FutureBlock(CASES[:1], count))
        self.close = lanes(FutureBlock(both, AT_ONCE * members))
        self.takeovers = lanes(FutureBlock(LIKELY[1 : 1 + len(CHANCES)], AT_ONCE))

    def columns(self, known: Gaussian, rudder: np.ndarray, alive: np.ndarray) -> dict[str, np.ndarray]:
        """What is foretold of each ship, by ``COLUMNS``; the rudder as it is indicated."""
        scouts, likely = self._drawn(known, self.members._normals[self.scouts]), self._points(known.mean)
        ships = [(scouts, np.repeat(rudder, len(self.scouts))), (likely, rudder)]
        some, one = self.first([self.forecaster._ships(*ship) for ship in ships])
        met = np.isfinite(some.contact).reshape(2, self.count, -1).any(axis=(0, 2))
        chances = {name: np.zeros(self.count) for name in ("soon", "later", "pilot_now")}
        for here in _parts(np.flatnonzero(met & alive)):
            for name, values in self._chances(known, rudder, here).items():
                chances[name][here] = values[: len(here)]
        contact = one.contact[0]
        last = self._last_chances(likely, rudder, contact, alive)
        return {**bridges_today(known.mean), "contact": contact, "last_chance": last, **chances}

    def _drawn(self, known: Gaussian, normals: np.ndarray) -> Samples:
        """Members of every ship."""
        points = known.mean[:, None] + normals[:, : known.mean.shape[1]] @ known.root.transpose(0, 2, 1)
        return self._points(points.reshape(-1, points.shape[2]))

    def _points(self, points: np.ndarray) -> Samples:
        size = len(self.forecaster.filter.states)
        return Samples(points[:, :size], self.members._coefficients(points[:, size:]))

    def _chances(self, known: Gaussian, rudder: np.ndarray, here: np.ndarray) -> dict[str, np.ndarray]:
        """By all members of some ships."""
        filled, normals = np.resize(here, AT_ONCE), self.members._normals
        drawn = self._drawn(Gaussian(known.mean[filled], known.root[filled]), normals)
        (ends,) = self.close([self.forecaster._ships(drawn, np.repeat(rudder[filled], len(normals)))])
        as_is, pilot = ends.contact.reshape(2, AT_ONCE, len(normals))
        shares = {"soon": as_is <= SOON, "later": as_is <= AFTER, "pilot_now": np.isfinite(pilot)}
        return {name: share.mean(axis=1) for name, share in shares.items()}

    def _last_chances(self, likely: Samples, rudder: np.ndarray, contact: np.ndarray, alive: np.ndarray) -> np.ndarray:
        """Of the likely runs that meet a bank soon, as ``LikelyRun`` tells it; 0 where it is gone."""
        last, times = np.full(self.count, math.inf), np.array([0.0, *CHANCES[:-1], math.inf])
        for here in _parts(np.flatnonzero((contact <= ALARMING) & alive)):
            filled = np.resize(here, AT_ONCE)
            part = Samples(likely.states[filled], likely.coefficients[filled])
            met = np.isfinite(self.takeovers([self.forecaster._ships(part, rudder[filled])])[0].contact)
            last[here] = times[np.where(met.any(axis=0), met.argmax(axis=0), len(CHANCES))][: len(here)]
        return last


def _parts(places: np.ndarray) -> list[np.ndarray]:
    return [places[first : first + AT_ONCE] for first in range(0, len(places), AT_ONCE)]


def bridges_today(mean: np.ndarray) -> dict[str, np.ndarray]:
    """Distance to the bank; time to contact straight on, and curved by the rate of turn."""
    beside = BridgePredictor(modelled().configuration.ship, WIDTH / 2, *mean[:, 1:6].T)
    return {"room": beside.now, "line": beside.straight_contact(AFTER), "curve": beside.curved_contact(AFTER)}
