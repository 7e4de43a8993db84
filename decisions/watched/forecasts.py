"""What is forecast of many ships at once: by the package's forecaster, and by what bridges have today."""

import numpy as np

from narrows.estimation.estimator import Estimator
from narrows.estimation.unscented import Gaussian
from narrows.warning.forecasting.forecaster import AFTER, ESCAPE_TIME, TAKEOVERS, BridgePredictor, Forecaster, judged
from narrows.warning.forecasting.future_lanes import Case, FutureBlock
from narrows.warning.forecasting.helmsman import Helmsmen
from watched.truths import LENGTH, NARROWS, bend_at, modelled

AT_ONCE, SCOUTS = 8, 16
"""Ships that are looked at closely in one call; samples that are sailed first: where none of them meets a bank in any
way, the chances are taken for 0, and the others stay at home."""
COLUMNS = (
    "room", "curve", "contact", "likely_chance", "last_chance", "nobody", "soon", "as_is", "failing",
    "unattended", "helmsman",
)  # fmt: skip


class ForecastsAbreast:
    """Forecasts of ships abreast, with how their rudders are used."""

    def __init__(self, estimator: Estimator, count: int, members: int) -> None:
        self.count, self.helmsmen = count, Helmsmen(count, LENGTH)
        self.close = Forecaster(estimator, members=members, escaping=members, ships=AT_ONCE)
        half, few = members // 2, min(SCOUTS, members) // 2
        self._scouts = np.r_[:few, half : half + few]
        self._first = self.close.laid_out(FutureBlock([Case(TAKEOVERS[-1] + ESCAPE_TIME)], count * len(self._scouts)))

    def observe(self, mean: np.ndarray, rudder: np.ndarray) -> np.ndarray:
        """Take in how the rudders are used in a second; what is taken in."""
        x, y, psi, u, _, r = mean[:, :6].T
        seen = y, psi, r - bend_at(x) * u, u, rudder
        self.helmsmen.update(*seen)
        return np.stack(seen)

    def columns(self, known: Gaussian, rudder: np.ndarray, alive: np.ndarray) -> dict[str, np.ndarray]:
        """What is forecast of each ship, by ``COLUMNS``; the rudder as it is indicated."""
        law = self.helmsmen.law(known.mean[:, 3])
        normals = self.close.members._normals[self._scouts]
        scouts = self.close.samples(
            self.close.members._samples(known.mean, known.root, normals), rudder, law, len(self._scouts)
        )
        (outcome,) = self._first([scouts])
        met = np.isfinite(outcome.contact).reshape(self.count, -1).any(axis=1) & alive
        told = {name: np.zeros(self.count) for name in COLUMNS}
        for name in ("contact", "likely_chance", "last_chance"):
            told[name] += np.inf
        for first in range(0, int(met.sum()), AT_ONCE):
            here = np.flatnonzero(met)[first : first + AT_ONCE]
            for name, values in self._closely(known, rudder, law, np.resize(here, AT_ONCE)).items():
                told[name][here] = values[: len(here)]
        return {**told, **bridges_today(known.mean), "unattended": self.helmsmen.unattended.copy()}

    def _closely(self, known: Gaussian, rudder: np.ndarray, law: dict, here: np.ndarray) -> dict[str, np.ndarray]:
        forecaster, mean, root = self.close, known.mean[here], known.root[here]
        helms = {name: values[here] for name, values in law.items()}
        blocks = [
            forecaster.samples(members.drawn(mean, root), rudder[here], helms, members.count)
            for members in (forecaster.members, forecaster.escaping)
        ]
        blocks.append(forecaster.samples(forecaster.members.likely(mean), rudder[here], helms, 1))
        outcomes = forecaster._lanes(blocks, 0.0)
        seen = judged(outcomes, AT_ONCE, len(forecaster.manoeuvres), self.helmsmen.unattended[here])
        failing = seen.failing[np.arange(AT_ONCE), seen.best, 0]
        return {name: getattr(seen, name) for name in COLUMNS[2:8]} | {"failing": failing, "helmsman": seen.helmsman}


def bridges_today(mean: np.ndarray) -> dict[str, np.ndarray]:
    """Distance to the bank; time to contact on a track curved by the rate of turn."""
    x, y, psi, u, v, r = mean[:, :6].T
    half = np.interp(x, *np.array(NARROWS).T)
    beside = BridgePredictor(modelled().configuration.ship, half[:, None], y, psi, u, v, r, bend_at(x))
    return {"room": beside._replace(half_width=half).now, "curve": beside.curved_contact(AFTER)}
