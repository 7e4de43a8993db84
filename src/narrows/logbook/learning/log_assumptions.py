"""What a fit takes for granted beside the model: how sensors err, whether gusts act, how long windows are."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from narrows.logbook.sensor_grades import SensorGrade, SignalGrade
from narrows.logbook.shooting.chain_likelihood import USUAL_MEMORY
from narrows.logbook.shooting.log_problem import STEADY, CoefficientPrior, LogProblem, PushInertia
from narrows.logbook.shooting.predicted_signals import CURRENT_X, CURRENT_Y, ERROR, PREDICTED
from narrows.logbook.shooting.push_chain import WindowChain
from narrows.logbook.shooting.recorded_helm import RUDDER, RUDDER_OFFSET
from narrows.logbook.shooting.recorded_motion import RecordedMotion

# Of windows that stand alone and of their steps, in times of a ship length.
WINDOW, STEP = 3.5, 1 / 25
# Of windows that hang together.
LINKED_WINDOW, LINKED_STEP = 1 / 10, 1 / 50
# Standard deviations of accelerations before anything is known, over speed squared by length (and by length again for
# yaw): of gusts, and of a push that stays.
GUST, STEADY_PUSH = 0.005, 0.1
# How much stronger pushes are than gusts usually are while another ship passes.
IN_MEETINGS = 30.0
# Standard deviation of a current that nothing is known of [m/s].
SPREAD_OF_CURRENT = 0.3
DEGREE = np.pi / 180
# What a model leaves of places in a basin, in lengths of the ship, its memory counted; four times as much of angles,
# five of yaw rates and twice as much of speeds, over those of the ship.
USUALLY_LEFT = 0.015
# The noise that counts is what the model leaves of the records.
BASIN = SensorGrade(
    "basin",
    "a towing tank: no wind, no current, noise estimated from the records",
    {
        **{name: SignalGrade(1e-6) for name in PREDICTED},
        RUDDER: SignalGrade(0.1 * DEGREE, zero=0.5 * DEGREE),
    },
)


@dataclass(frozen=True)
class LogAssumptions:
    """What is taken for granted."""

    grade: SensorGrade  # Of the sensors
    gusts: bool  # Whether pushes with a memory act
    surge: str  # Whether the speed is integrated
    window: float | None = None  # Of a window [s]
    outlier: float = 4.0  # Residual over its noise beyond which a reading counts less [1]
    choices: Mapping[str, Any] = field(default_factory=dict)  # Further ones of the simulation

    def lengths(self, length: float, u: float) -> tuple[float, float]:
        """Return the lengths of windows and of steps [s]."""
        # length [m]; u [m/s]
        usual, step = (LINKED_WINDOW, LINKED_STEP) if self.gusts else (WINDOW, STEP)
        window = self.window or usual * length / u
        return window, float(f"{min(step * length / u, window / 5):.2g}")

    def problem(
        self, motion: RecordedMotion, prior: CoefficientPrior, inertia: PushInertia, signals: set[str], u: float
    ) -> LogProblem:
        """Return what is solved for."""
        # u [m/s]
        length = motion.model.configuration.ship.length
        noise, sizes = self._noise(signals, length, u), self._sizes(length, u)
        chain = self._chain(signals, sizes, motion) if self.gusts else WindowChain()
        zeros = self._zeros(signals, motion) | (
            {STEADY(name): STEADY_PUSH * size for name, size in sizes.items()} if self.gusts else {}
        )
        met = chain.stronger(IN_MEETINGS)
        return LogProblem(motion, prior, inertia, chain, met, zeros, noise, self.gusts, self.outlier)

    def _noise(self, signals: set[str], length: float, u: float) -> dict[str, float]:
        """Of the grade; in a basin what models usually leave, to begin with."""
        read = [name for name in PREDICTED if name in signals]
        if self.grade.name != BASIN.name:
            return {name: self._grade(name).noise for name in read}
        angle, rate = USUALLY_LEFT * 4, USUALLY_LEFT * 5 * u / length
        sizes = {"x": USUALLY_LEFT * length, "y": USUALLY_LEFT * length, "psi": angle, "course": angle, "r": rate}
        return {name: sizes.get(name, USUALLY_LEFT * 2 * u) for name in read}

    @property
    def least_noise(self) -> dict[str, float]:
        """Noise of each signal at least, however little a model leaves of it."""
        return {name: self._grade(name).noise for name in PREDICTED}

    def _grade(self, name: str) -> SignalGrade:
        """The grade of a signal; of one that the sensors are not said to have, that of the nearest."""
        nearest = {"u_ground": "u", "speed_over_ground": "u", "course": "psi", "v_ground": "u", "v": "u"}
        graded = self.grade.signals
        return graded.get(name) or graded.get(nearest.get(name, name)) or UNGRADED[name]

    def _sizes(self, length: float, u: float) -> dict[str, float]:
        """Accelerations that pushes are measured by."""
        along = {"X": u * u / length} if self.surge == "free" else {}
        return {**along, "Y": u * u / length, "N": (u / length) ** 2}

    def _chain(self, signals: set[str], sizes: Mapping[str, float], motion: RecordedMotion) -> WindowChain:
        window, _ = self.lengths(motion.model.configuration.ship.length, float(motion.choices["u"]))
        items = [(name, GUST * size, USUAL_MEMORY) for name, size in sizes.items()]
        if RUDDER in signals:
            rudder = self._grade(RUDDER)
            items.append((RUDDER_OFFSET, rudder.noise * np.sqrt(rudder.period / window), 0.0))
        for name in PREDICTED:
            if name in signals and (grade := self._grade(name)).wander > 0:
                items.append((ERROR(name), grade.wander, grade.memory))
        names, std, memory = zip(*items, strict=True)
        return WindowChain(names, np.array(std), np.array(memory))

    def _zeros(self, signals: set[str], motion: RecordedMotion) -> dict[str, float]:
        told = {ERROR(name): self._grade(name).zero for name in PREDICTED if name in signals and name != "x"}
        told |= {RUDDER_OFFSET: self._grade(RUDDER).zero} if RUDDER in signals else {}
        over_ground = signals & {"u_ground", "v_ground", "speed_over_ground", "course", "x"}
        if over_ground and self.grade.name != BASIN.name:
            told[CURRENT_X] = SPREAD_OF_CURRENT
            if not motion.model.feels_bank:
                told[CURRENT_Y] = SPREAD_OF_CURRENT
        return {name: size for name, size in told.items() if size > 0}


# Of signals that a grade says nothing of.
UNGRADED = {
    "x": SignalGrade(1.0), "y": SignalGrade(1.0), "psi": SignalGrade(0.3 * DEGREE), "r": SignalGrade(0.02 * DEGREE),
    "u": SignalGrade(0.1), "v": SignalGrade(0.1), "u_ground": SignalGrade(0.1), "v_ground": SignalGrade(0.1),
    "speed_over_ground": SignalGrade(0.1), "course": SignalGrade(2 * DEGREE), RUDDER: SignalGrade(0.5 * DEGREE),
}  # fmt: skip
