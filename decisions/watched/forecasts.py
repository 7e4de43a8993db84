"""What is forecast of many ships at once: by the package's forecaster, and by what bridges have today."""

import numpy as np

from narrows.estimation.estimator import Estimator
from narrows.estimation.states import Gaussian
from narrows.ship.particulars import half_swept
from narrows.warning.forecasting.forecaster import (
    AFTER,
    ESCAPE_TIME,
    TAKEOVERS,
    Forecaster,
    wrong_order_chance,
)
from narrows.warning.forecasting.helmsman import Case, FutureBlock, Helmsmen
from watched.truths import LENGTH, NARROWS, bend_at, modelled

AT_ONCE, SCOUTS = 8, 16
"""Ships that are looked at closely in one call; samples that are sailed first: where none of them meets a bank in any
way, the chances are taken for 0, and the others stay at home."""
TRACK_STEP = 2.0
"""Between points of a track without a model [s]."""
COLUMNS = (
    "room", "curve", "contact", "likely_chance", "last_chance", "nobody", "as_is", "failing",
    "unattended", "helmsman", "escapes", "wrong_order",
)  # fmt: skip


class ForecastsAbreast:
    """Forecasts of ships abreast, with how their rudders are used."""

    def __init__(self, estimator: Estimator, count: int, members: int) -> None:
        self.count, self.helmsmen = count, Helmsmen(count, LENGTH)
        self.across = estimator.filter.states.places["current_across"]
        self.close = Forecaster(estimator, members=members, escaping=members, ships=AT_ONCE)
        half, few = members // 2, min(SCOUTS, members) // 2
        self._scouts = self.close.members[np.r_[:few, half : half + few]]
        self._wrong = self.close.laid_out(FutureBlock(self.close.wrong_orders, count))
        self._first = self.close.laid_out(FutureBlock([Case(TAKEOVERS[-1] + ESCAPE_TIME)], AT_ONCE * len(self._scouts)))

    def observe(self, mean: np.ndarray, rudder: np.ndarray) -> np.ndarray:
        """Take in how the rudders are used in a second; what is taken in."""
        x, y, psi, u, _, r = mean[:, :6].T
        seen = y, psi, r - bend_at(x) * u, u, rudder
        self.helmsmen.update(*seen)
        return np.stack([*seen, mean[:, self.across]])

    def columns(self, known: Gaussian, rudder: np.ndarray, looked: np.ndarray) -> dict[str, np.ndarray]:
        """What is forecast of the ships that are looked at, by ``COLUMNS``; the rudder as it is indicated."""
        told = {name: np.zeros(self.count) for name in COLUMNS} | {"escapes": np.zeros((self.count, len(TAKEOVERS)))}
        for name in ("contact", "likely_chance", "last_chance"):
            told[name] += np.inf
        met = [here[self._meets(known, rudder, here)[: len(here)]] for here in batches(np.flatnonzero(looked))]
        for here in batches(np.concatenate([np.zeros(0, int), *met])):
            for name, values in self._closely(known, rudder, np.resize(here, AT_ONCE)).items():
                told[name][here] = values[: len(here)]
        law = self._law(known, np.arange(self.count))
        (wrong,) = self._wrong([self.close.sampled(known.mean, known.root, self.close.likely, rudder, law)])
        told["wrong_order"] = wrong_order_chance(np.isfinite(wrong.contact))
        return {
            **told,
            **bridges_today(known.mean, known.mean[:, self.across]),
            "unattended": self.helmsmen.unattended.copy(),
        }

    def _meets(self, known: Gaussian, rudder: np.ndarray, here: np.ndarray) -> np.ndarray:
        """Which of some ships meet a bank at all if nobody acts, by the scouts."""
        here = np.resize(here, AT_ONCE)
        mean, root, law = known.mean[here], known.root[here], self._law(known, here)
        (outcome,) = self._first([self.close.sampled(mean, root, self._scouts, rudder[here], law)])
        return np.asarray(np.isfinite(outcome.contact).reshape(AT_ONCE, -1).any(axis=1))

    def _law(self, known: Gaussian, here: np.ndarray) -> dict[str, np.ndarray]:
        return {name: values[here] for name, values in self.helmsmen.law(known.mean[:, 3]).items()}

    def _closely(self, known: Gaussian, rudder: np.ndarray, here: np.ndarray) -> dict[str, np.ndarray]:
        law, unattended = self._law(known, here), self.helmsmen.unattended[here]
        seen = self.close.judge(known.mean[here], known.root[here], rudder[here], law, unattended)
        failing = seen.failing[np.arange(AT_ONCE), seen.best, 0]
        return {name: getattr(seen, name) for name in COLUMNS[2:7]} | {
            "failing": failing, "helmsman": seen.helmsman, "escapes": seen.failing.min(axis=1),
        }  # fmt: skip


def batches(ships: np.ndarray) -> list[np.ndarray]:
    return [ships[first : first + AT_ONCE] for first in range(0, len(ships), AT_ONCE)]


def bridges_today(mean: np.ndarray, across: np.ndarray) -> dict[str, np.ndarray]:
    """Distance to the bank; time to contact on a track curved by the rate of turn."""
    x, y, psi, u, v, r = mean[:, :6].T
    half, hull = np.interp(x, *np.array(NARROWS).T), modelled().configuration.ship
    t = np.arange(0.0, AFTER + TRACK_STEP / 2, TRACK_STEP)
    turned = psi[:, None] + (r - bend_at(x) * u)[:, None] * t
    speed = u[:, None] * np.sin(turned) + (v + across)[:, None] * np.cos(turned)
    gone = np.cumsum((speed[:, 1:] + speed[:, :-1]) / 2 * TRACK_STEP, axis=1)
    offset = y[:, None] + np.concatenate([np.zeros((len(y), 1)), gone], axis=1)
    met = half[:, None] - np.abs(offset) - half_swept(hull, turned) <= 0.0
    curve = np.where(met.any(axis=1), t[met.argmax(axis=1)], np.inf)
    return {"room": half - np.abs(y) - half_swept(hull, psi), "curve": curve}
