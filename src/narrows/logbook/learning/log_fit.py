"""Result of learning from a log: coefficients, contributions of records, and prediction errors of left-out records."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from narrows.base.results import Aliased
from narrows.codegen.cache import compiled_loops
from narrows.logbook.filtering import kalman_loops
from narrows.logbook.filtering.likelihood import FIRST_PASSES, RecordLikelihood, RecordPath, RecordScore, SearchResult
from narrows.logbook.filtering.log_problem import CURRENT, INPUTS, PUSHES, LogProblem, StochasticModel
from narrows.logbook.filtering.record_grid import CURRENTS, HELM, OFFSET, RUDDER, STATES, RecordGrid
from narrows.logbook.learned_coefficients import LEARNED, ON_TWINS, LearnedAnswer
from narrows.logbook.ship_log import size_of

HORIZON = 3.5  # Length of a forecast [ship lengths]
JUDGED = ("y", "psi", "r")  # States whose forecasts are judged
MOST_COMPARED = 50  # Most records for predictions of whole records and Nomoto models
# Standard deviations of a fitted start about the smoothed one: heading [rad]; u, v and r relative to the ship's scales.
START_FREE = np.array([0.01, 0.05, 0.05, 0.05])
# Start of a Nomoto fit: yaw rate over speed and length, per rudder angle [1].
USUAL_TURN = 0.5
# Errors of a heading [rad] and of the yaw rate at the start [rad/s]: weights of a fitted start.
READING, START_RATE = 0.01, 0.01


@dataclass(frozen=True)
class RecordAnswer(Aliased):
    name: str  # Name of the record
    duration: float  # Duration [s]
    zeros: dict[str, float]  # Constant errors and disturbances of the record, in SI; disturbances as accelerations
    information: dict[str, float]  # Share of each coefficient's information that comes from the record [1]
    # Root mean square errors of forecasts over 3.5 ship lengths of y [m], psi [rad] and r [rad/s]: by the model before
    # the log, and by the model learned from all other records
    forecast_rmse: dict[str, tuple[float, float]]
    # Root mean square heading errors [rad] of predictions of the whole record from its rudder, with a fitted start: by
    # the model ``before``, ``after`` the other records, and a nonlinear ``nomoto`` model of those; empty with gusts
    whole: Mapping[str, float] = field(default_factory=dict)


def record_answers(found: SearchResult, grids: Iterable[RecordGrid]) -> tuple[RecordAnswer, ...]:
    whole, scales = not found.problem.model.gusts and not found.interrupted, found.problem.scales
    nomoto = nomoto_errors(grids, scales[0] / scales[3]) if whole and len(found.records) <= MOST_COMPARED else []
    return tuple(
        _answer(found, grid, one, nomoto[number] if nomoto else None)
        for number, (grid, one) in enumerate(zip(grids, found.records, strict=False))
    )


def _answer(found: SearchResult, grid: RecordGrid, one: RecordScore, nomoto: float | None) -> RecordAnswer:
    problem, prior, count = found.problem, found.problem.prior, found.problem.count
    after = problem.covariance(found.information)
    without = problem.covariance(found.information - one.information)
    moved = (without @ one.score)[:count] * prior.free
    gone = np.clip(1 - np.diag(after) / np.diag(without), 0.0, 1.0)[:count]
    path = one.path or RecordLikelihood(problem, grid).smoothed(found.unknowns, None, FIRST_PASSES)
    assert path is not None
    before_it = np.zeros(count)  # Prior mean; also the estimate without the only record
    without_it = found.scaled * prior.free - moved if len(found.records) > 1 else before_it
    model, starts = problem.model_at(found.unknowns), {"before": before_it, "after": without_it}
    before, later = (rms_of(forecast_errors(problem, at, grid, path, model)) for at in starts.values())
    heading = {name: whole_record_error(problem, at, grid, path) for name, at in starts.items() if nomoto is not None}
    zeros = {
        process.name: float(path.processes[0, place]) for place, process in enumerate(model.processes)
        if np.isinf(process.memory) and not process.name.startswith(HELM)
    }  # fmt: skip
    return RecordAnswer(
        grid.record.name, float(grid.times[-1] - grid.times[0]), zeros,
        dict(zip(prior.names, gone.tolist(), strict=True)), {name: (before[name], later[name]) for name in JUDGED},
        heading if nomoto is None else heading | {"nomoto": nomoto},
    )  # fmt: skip


def rms_of(errors: np.ndarray) -> dict[str, float]:
    with np.errstate(all="ignore"):  # A diverged forecast may be infinite.
        root = np.sqrt(np.mean(errors**2, axis=0)) if len(errors) else np.full(6, np.nan)
    return {name: float(root[STATES.index(name)]) for name in JUDGED}


def forecast_errors(
    problem: LogProblem, scaled: np.ndarray, grid: RecordGrid, path: RecordPath, model: StochasticModel
) -> np.ndarray:
    """Return the errors of forecasts from smoothed states, without gusts, at scaled coefficients (p,); (pieces, 6)."""
    reach = HORIZON * problem.scales[0] / max(float(np.abs(path.states[:, 3]).mean()), 1e-3)
    every = max(1, min(round(reach / grid.step), (len(grid) - 1) // 2))
    begun = np.arange(0, len(grid), every)
    known = dict.fromkeys(INPUTS, 0.0)
    for place, process in enumerate(model.processes):
        if np.isinf(process.memory) and process.adds_to in known:
            known[process.adds_to] += float(path.processes[0, place])
    motion, inertia = problem.at(scaled)
    pushes = np.tile(inertia * [known[name] for name in PUSHES], (len(begun) - 1, 1))
    offsets = {name: np.full(len(begun) - 1, known.get(OFFSET(name), 0.0)) for name in motion.positions}
    with np.errstate(all="ignore"):  # A model before the log may run away.
        states, _ = motion.sailed(
            path.states[begun[:-1]], pushes, begun, grid.times, grid.positions, offsets, known[CURRENTS[0]]
        )
        off = states[every :: every + 1] - path.states[begun[1:]]
    if CURRENT not in problem.motion.directions:
        off[:, :2] += every * grid.step * np.array([known[name] for name in CURRENTS])
    return np.asarray(off)


def whole_record_error(problem: LogProblem, scaled: np.ndarray, grid: RecordGrid, path: RecordPath) -> float:  # [rad]
    if "psi" not in grid.readings:
        return np.nan
    motion, read, scales = problem.at(scaled)[0], grid.readings["psi"], problem.scales
    ends, at, share = np.array([0, len(grid)]), read.step, read.share

    def residuals_at(start: np.ndarray) -> np.ndarray:  # (readings + 4,)
        begun = path.states[0].copy()
        begun[2:] += START_FREE * scales[2:] * start
        with np.errstate(all="ignore"):
            heading = motion.sailed(begun[None], np.zeros((1, 3)), ends, grid.times, grid.positions)[0][:, 2]
            off = ((1 - share) * heading[at] + share * heading[at + 1] - read.values) / READING
        return np.append(np.nan_to_num(off, nan=1e3, posinf=1e3, neginf=-1e3).clip(-1e3, 1e3), start)

    found = least_squares(residuals_at, np.zeros(4), max_nfev=15)
    return float(READING * np.sqrt(np.mean(found.fun[:-4] ** 2)))


def _nomoto_errors(
    start: np.ndarray, numbers: np.ndarray, step: float, rudder: np.ndarray, heading: np.ndarray
) -> np.ndarray:
    """Return the heading errors, over READING, of ``rdot = a rudder + b + c r + d |r| r + e r^3`` (Euler's method)."""
    # start (2,): heading and yaw rate off those recorded, in units of READING and START_RATE
    few = min(10, len(heading) - 1)
    psi, r = heading[0] + READING * start[0], (heading[few] - heading[0]) / few / step + START_RATE * start[1]
    path = compiled_loops(kalman_loops).nomoto_headings(np.asarray(numbers), psi, r, step, rudder)
    return np.asarray((path - heading) / READING)


def nomoto_errors(grids: Iterable[RecordGrid], time: float) -> list[float]:
    """Return the root mean square heading error [rad] of each record by a Nomoto model fitted to all others."""
    # time [s] of a ship length. The model of an only record is fitted to itself. Starts are fitted too. NaN without
    # rudder or heading.
    scale = np.array([1.0, 0.01, time, time**2, time**3]) / time**2
    first = np.array([USUAL_TURN, 0.0, -1.0, 0.0, -4.0])

    def residuals(unknowns: np.ndarray, records: Sequence[Any]) -> np.ndarray:
        numbers, starts = unknowns[: len(first)] * scale, unknowns[len(first) :].reshape(-1, 2)
        return np.concatenate(
            [_nomoto_errors(start, numbers, *own) for own, start in zip(records, starts, strict=True)]
        )

    known = [
        (grid.step, grid.positions[RUDDER], np.interp(grid.times, grid.times_of(read), read.values))
        if (read := grid.readings.get("psi")) and RUDDER in grid.positions else None
        for grid in grids
    ]  # fmt: skip
    steered, missed = [record for record in known if record], np.full(len(known), np.nan)
    for place, record in enumerate(known):
        if record is not None:
            others = [other for other in steered if other is not record] or [record]
            unknowns = np.append(first, np.zeros(2 * len(others)))
            numbers = scale * least_squares(residuals, unknowns, args=(others,), max_nfev=40).x[: len(first)]
            left = least_squares(_nomoto_errors, np.zeros(2), args=(numbers, *record), max_nfev=40).fun
            missed[place] = np.sqrt(np.mean(left**2)) * READING
    return missed.tolist()


CONTRADICTION_PROBABILITY = 1e-3  # Probability below which log and prior contradict each other
# Ratio of disturbances to prior gusts [1] that gusts do not explain: 5 % of twins with gusts alone exceed 5; 90 % of
# twins that another ship passes every ten minutes exceed 17.
UNEXPLAINED_GUST_RATIO = 8.0
HEADING_LEFT = np.radians(0.5)  # Residual noise of headings that exceeds the error of a compass [rad]
MOVED_STDS = 3.0  # Change from which a contradiction names a coefficient [prior standard deviations]


class Gusts(NamedTuple):
    sway: float  # Standard deviation of the acceleration [m/s2]
    yaw: float  # Likewise [rad/s2]
    memory: float  # Correlation time [s]
    correlation: float  # Between the two [1]
    strength: float  # Standard deviation over the prior one, the larger of sway and yaw [1]


class SignalNoise(NamedTuple):
    size: float  # Standard deviation of a reading [unit of the signal]
    beyond: float  # Share of readings down-weighted as outliers [1]


@dataclass(frozen=True, repr=False)
class LogFit(LearnedAnswer):
    """Result of learning from a log."""

    records: tuple[RecordAnswer, ...]  #: Contribution of each record
    gusts: Gusts | None  #: Most likely gusts, if they were estimated
    noise: Mapping[str, SignalNoise]  #: Noise of a reading of each signal
    disagreement: float  #: Sum of squared changes of the coefficients over their expected errors [1]
    freedom: int  #: Number of combinations of coefficients that the log determines
    probability: float  #: Probability of at least this sum if log and prior belong to one ship [1]
    about: tuple[str, ...]  #: Assumptions, and records that were left out
    converged: bool  #: Whether the search converged

    @property
    def informative(self) -> bool:
        """True where the log determined a coefficient: one of the bank, where the model has one."""
        asked = [c for c in self.coefficients.values() if c.from_bank or not self.prior.has_bank]
        return any(c.status == LEARNED for c in asked)

    @property
    def disagrees(self) -> bool:
        """True where log and prior contradict each other."""
        return self.probability < CONTRADICTION_PROBABILITY

    @property
    def has_unexplained_disturbance(self) -> bool:
        """True where disturbances are too strong for gusts, as with passing ships that the log lacks."""
        return self.gusts is not None and self.gusts.strength > UNEXPLAINED_GUST_RATIO

    @property
    def notes(self) -> tuple[str, ...]:
        """Contradictions, assumptions, and left-out records."""
        inertia = "Motion determines only forces over inertia: inertia keeps its prior."
        open_water = "Learning in open water is tested against measured manoeuvres."
        return (*self._doubts, inertia, *self.about, *(() if self.prior.has_bank else (open_water,)), ON_TWINS)

    @property
    def _doubts(self) -> tuple[str, ...]:
        uncertain = [c for c in self.coefficients.values() if c.prior_std > 0]
        far = [c.name for c in uncertain if abs(c.value - c.prior) > MOVED_STDS * c.prior_std]
        named = f", mainly in {', '.join(far)}" if far else ""
        left = self.noise["psi"].size if "psi" in self.noise else 0.0
        strength, whole = self.gusts.strength if self.gusts else 0.0, self.whole_missed
        doubts = {
            f"Log and prior contradict each other{named}: the sum of squares is {self.disagreement:.0f}, the expected "
            f"value {self.freedom}. Check the signs of rudder and yaw rate, and whether the log is from another ship "
            "or draft. Otherwise one of the stated errors is too small.": self.disagrees,
            "The search did not converge: do not rely on these numbers.": not self.converged,
            "This model predicts the heading of left-out records less well than a nonlinear Nomoto model of the same "
            "records. Do not rely on it for manoeuvres like these.": bool(whole) and whole["after"] > whole["nomoto"],
            f"The learned model misses the heading by {np.degrees(left):.1f} deg, more than the error of a compass. "
            "Its terms do not fit this log. Check whether the log is from another ship or draft.": left >= HEADING_LEFT,
            f"Disturbances are {strength:.0f} times as strong as the prior gusts. Other ships may have passed: mark "
            "these times in the log (`meeting`). Otherwise intervals are too narrow.": self.has_unexplained_disturbance,
        }
        return tuple(sentence for sentence, holds in doubts.items() if holds)

    def summary(self) -> str:
        gusty = "" if self.gusts is None else (
            f"Estimated gusts: {self.gusts.sway:.2g} m/s2 in sway and {self.gusts.yaw:.2g} rad/s2 in yaw (standard "
            f"deviations), with a correlation time of {self.gusts.memory:.0f} s."
        )  # fmt: skip
        taught = self._learned_sentence(size_of([record.duration for record in self.records], len(self.records)))
        return "\n".join(filter(None, (*self._doubts, taught, self._prediction, gusty, ON_TWINS)))

    @property
    def _prediction(self) -> str:
        before, after = np.degrees(self.forecast_rmse("psi"))
        if len(self.records) < 2 or not np.isfinite([before, after]).all():
            return ""
        if self.whole_missed:
            before, after, nomoto = np.degrees(list(self.whole_missed.values()))
            return (
                f"Heading error over whole left-out records: {after:.2g} deg; {before:.2g} deg with the prior model, "
                f"{nomoto:.2g} deg with a nonlinear Nomoto model."
            )
        worse = " The log does not improve forecasts." * bool(after >= before)
        return (
            f"Heading error of forecasts over 3.5 ship lengths in left-out records: {after:.2g} deg; {before:.2g} deg "
            f"with the prior model.{worse}"
        )

    @property
    def whole_missed(self) -> dict[str, float]:
        """Root mean square heading error over whole records [rad], by model; empty with gusts."""
        rows = [record.whole for record in self.records if np.isfinite(record.whole.get("after", np.nan))]
        if len(rows) < 2:
            return {}
        return {name: float(np.sqrt(np.mean([row[name] ** 2 for row in rows]))) for name in rows[0]}

    def forecast_rmse(self, state: str) -> tuple[float, float]:
        """Return the forecast errors of prior and learned model on left-out records of a ``state``: y, psi or r."""
        rows = np.array([record.forecast_rmse[state] for record in self.records]).reshape(-1, 2)
        rows = rows[np.isfinite(rows).all(axis=1)]
        before, after = np.sqrt(np.mean(rows**2, axis=0)).tolist() if len(rows) else (np.nan, np.nan)
        return before, after

    def to_dict(self) -> dict[str, Any]:
        return {
            "summary": self.summary(),
            "informative": self.informative,
            "coefficients": [coefficient.to_dict() for coefficient in self.coefficients.values()],
            "disagreement": {"sum": self.disagreement, "freedom": self.freedom, "probability": self.probability},
            "gusts": None if self.gusts is None else self.gusts._asdict(),
            "noise": {name: {"size": left.size, "outliers": left.beyond} for name, left in self.noise.items()},
            "records": [
                {name: getattr(r, name) for name in ("name", "duration", "zeros", "information", "whole")}
                | {"missed": {name: {"before": old, "after": new} for name, (old, new) in r.forecast_rmse.items()}}
                for r in self.records
            ],
            "settled": self.converged,
            "notes": list(self.notes),
        }  # fmt: skip
