"""The estimator: a ship's position and motion and the effects of banks, current and gear, from readings.

In real time by a filter forward; of whole records by the smoother too, with the coefficients among the states.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_choice, did_you_mean
from narrows.base.results import BaseSummary
from narrows.estimation import settings
from narrows.estimation.filter_run import AGROUND, FaultBank, FilterRun, Moment, Start
from narrows.estimation.sensors import Sensor, split_sensors
from narrows.estimation.ship_filter import MODEL, Coefficients, MotionStep, ShipFilter, UpdateResult
from narrows.estimation.states import Estimate, EstimatedTrack, Gaussian, Prior, ProcessNoise
from narrows.model.model import Model
from narrows.quantities.names import GRAVITY
from narrows.ship.checks import is_finite
from narrows.simulation.kernel_run import RUDDER

if TYPE_CHECKING:
    import pandas as pd

    from narrows.waterway.waterway import Waterway

# Readings from a bridge: by name, checked, without NaN.
Reading = float | Sequence[float]
# Notes of an estimate by the fields of an ``UpdateResult``.
SENTENCES = {
    "refused": "The reading of {} is too far from the prediction: refused.",
    "surprising": "The readings of {} contradict the prediction: the model is wrong.",
    "suspects": "The readings of {} are biased: it drifts, or is spoofed.",
}


@accept_aliases
class Estimator(BaseSummary):
    """A square-root unscented filter of a ship in a canal or a waterway, in real time.

    By default it also corrects the model's coefficients, starting from the covariance of the fit: a filter with fixed
    coefficients may have consistent innovations and yet wrong states. The corrections fade.

    Raises an InputError if a sensor is invalid, two share a name, or a number is invalid.

    Source: van der Merwe and Wan (2001), The square-root unscented Kalman filter for state and parameter estimation.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    sensors : sequence of Sensor and RudderIndicator
        ``Gnss``, ``Gyro``, ``RateOfTurn``, ``Log``, ``CourseOverGround``, ``RudderIndicator``, or of your own subclass
        of ``Sensor``.
    waterway : Waterway, optional
        Waterway instead of the model's own canal.
    noise, prior : ProcessNoise, Prior, optional
        Random walks of the motion about the model, and uncertainty before any reading; by the ship's length unless
        given.
    coefficients : {"estimated", "certain"}
        Use of the coefficients' covariance: ``estimated`` corrects the coefficients by the readings; ``certain``
        ignores it, in two thirds of the time.
    memory : float [s]
        Time in which corrections of the coefficients fade back to the fit, since the model's form is uncertain too;
        ``math.inf``: never.
    refusing : float [1]
        Probability that a gate refuses a valid reading; 0 for no gates.
    """

    def __init__(
        self, model: Model, sensors: Sequence[Any], *, waterway: "Waterway | None" = None,
        noise: ProcessNoise | None = None, prior: Prior | None = None, coefficients: Coefficients = "estimated",
        memory: float = settings.COEFFICIENT_MEMORY, refusing: float = 1e-5,
    ) -> None:  # fmt: skip
        check_choice("coefficients", coefficients, get_args(Coefficients))
        length = model.configuration.ship.length
        by_name, indicator = split_sensors(sensors)
        longest = math.sqrt(length / GRAVITY) / settings.STEPS_A_PERIOD
        self.filter = ShipFilter(
            model, by_name, indicator, waterway, noise or ProcessNoise.of_length(length),
            prior or Prior.of_length(length), coefficients, refusing, longest, float(memory),
        )  # fmt: skip
        self.forget()

    def forget(self) -> None:
        """Restart, as before the first reading."""
        self._last: Gaussian | None = None
        self._begin_anew(0.0)

    def _begin_anew(self, t: float) -> None:
        self._start, self._bank = Start(self.filter), FaultBank(self.filter, t)
        self._run: FilterRun | None = None
        self._last_reading: dict[str, float] = {}
        self._verdict = ""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on validity before use."""
        model = self.filter.model
        why = "The model has no covariance of its coefficients, so the estimate treats them as certain."
        return (*model.bank_notes, *((why,) if model.covariance is None else ()))

    def summary(self) -> str:
        ship, filter = self.filter.model.configuration.ship, self.filter
        return f"{', '.join(filter.states.names)} of {ship.name} by {', '.join(filter.sensors)}"

    def update(self, t: float, readings: Mapping[str, Any] | None = None, **named: Reading) -> Estimate:
        """Use the readings of a time ``t`` [s], and return the estimate at that time: finite for any input.

        Readings are given by the names of sensors and actuators, as a mapping or by keyword: ``{"gnss": (x, y),
        "gyro": psi, "rudder": angle}``, SI and rad. A late reading is inserted at its time, and later updates are
        repeated. NaN means no reading. Rudder angle and propeller revolutions keep their value until the next reading.
        ``notes`` of the estimate name invalid readings; one without a sensor, or with the wrong number of components,
        raises an InputError.
        """
        if not is_finite(t):
            raise InputError(f"t = {t} is no time; give seconds, then the readings")
        given = {**(readings or {}), **named}
        measured, positions, notes = checked_readings(given, self.filter.sensors, self.filter.actuators)
        if self._run and abs(gap := t - self._run.last.t) > settings.LONGEST_GAP:
            what = f"No reading for {gap:.0f} s" if gap > 0.0 else f"The time went back by {-gap:.0f} s"
            notes.append(f"{what}: the estimate begins anew.")
            self._begin_anew(t)
        process = self._collect_start if self._run is None else self._advance
        return process(float(t), measured, positions, notes)

    @accept_aliases
    def run(self, records: Any) -> EstimatedTrack:
        """Estimate a whole record as in real time, after a restart, from the first time with enough readings to start.

        ``records`` has a row for each time: ``t`` [s], the fields of the sensors (``gnss_x``, ``gnss_y``, ``gyro`` ...)
        and positions of actuators (``rudder`` [rad], ``revolutions`` [1/s]); NaN for no reading.
        """
        recorded = records_of(records, self.filter.sensors, self.filter.actuators)
        self.forget()
        found = [self.update(t, now) for t, now in rows_of(recorded, self.filter.sensors, self.filter.actuators)]
        known = [estimate for estimate in found if estimate.normal]
        if not known:
            raise self._start.refusal()
        refused, suspected = (
            {name: np.array([name in getattr(one, kind) for one in known]) for name in self.filter.sensors}
            for kind in ("refused", "suspects")
        )
        begun = dict.fromkeys(note for one in known for note in one.notes if note.startswith("At t = "))
        return EstimatedTrack(
            np.array([one.t for one in known]), np.array([list(one.values.values()) for one in known]),
            np.array([one.covariance for one in known]), self.filter.states.names,
            np.array([one.ready for one in known]), refused, suspected, False, (*self.notes, *begun),
        )  # fmt: skip

    @accept_aliases
    def smooth(self, records: Any) -> EstimatedTrack:
        """Estimate a whole record afterwards: each state from all readings, before and after it.

        The uncertain coefficients are estimated together with the states, from the fit's covariance. Parameters and
        errors are those of ``run``.
        """
        return smoothed_track(self.filter, records_of(records, self.filter.sensors, self.filter.actuators), self.notes)

    def _collect_start(
        self, t: float, measured: dict[str, tuple[float, ...]], positions: dict[str, float], notes: list[str]
    ) -> Estimate:
        start = self._start
        for name in self._silences(t):
            start.readings.pop(name, None)  # Too old for a start
        delays = {name: self.filter.sensors[name].delay for name in measured}
        for name, reading in measured.items():
            start.add(t - delays[name], {name: reading})
        late = max(delays.values(), default=0.0)
        self._last_reading.update(dict.fromkeys(measured, t))
        if start.missing:
            notes.append(f"An estimate starts from {settings.START_READINGS} readings each; it lacks {start.missing}.")
            return self._estimate(t, self._last, False, notes)
        first = Moment(
            t - late, start.state(t - late), self._indicated(positions, self.filter.at_rest), {}, self.filter.monitor()
        )
        self._bank = FaultBank(self.filter, t)
        self._run = FilterRun(self.filter, [first], self._bank.horizon, self._bank.kept)
        return self._advance(t, {}, positions, notes)

    def _advance(
        self, t: float, measured: dict[str, tuple[float, ...]], positions: dict[str, float], notes: list[str]
    ) -> Estimate:
        assert self._run is not None
        last = self._run.last
        if t < last.t - settings.SAME_TIME:
            notes.append(f"The time went back from {last.t:g} to {t:g} s: the readings count as late.")
        now = max(t, last.t)
        at = self._indicated(positions, last.positions) if t >= last.t - settings.SAME_TIME else last.positions
        self._last_reading.update(dict.fromkeys(measured, now))
        if not self._run.update(t, measured, at, notes):
            notes.append(AGROUND.format(t))
            self._begin_anew(t)
            return self._collect_start(t, measured, positions, notes)
        results = self._run.results
        indicated = {RUDDER: (positions[RUDDER],)} if RUDDER in positions else {}
        self._run, verdict = self._bank.test_hypotheses(self._run, {**measured, **indicated})
        self._verdict = verdict or self._verdict
        self._last = self.filter.adopt(self._run.last.state, self._run.filter)
        notes += [f"No reading of {name} came for {time:.0f} s." for name, time in self._silences(now).items()]
        return self._estimate(now, self._last, True, notes, results)

    def _indicated(self, positions: dict[str, float], before: np.ndarray) -> np.ndarray:
        both = zip(self.filter.actuators, before.tolist(), strict=True)
        return np.array([positions.get(name, last) for name, last in both], float)

    def _silences(self, now: float) -> dict[str, float]:  # [s]
        quiet = {name: now - self._last_reading.setdefault(name, now) for name in self.filter.sensors}
        longest = {name: settings.SILENT_PERIODS * sensor.period for name, sensor in self.filter.sensors.items()}
        return {name: time for name, time in quiet.items() if not 0.0 <= time <= longest[name]}

    def _estimate(
        self, t: float, joint: Gaussian | None, ready: bool, notes: list[str], results: Sequence[UpdateResult] = ()
    ) -> Estimate:
        nis = {name: square for result in results for name, square in result.nis.items()}
        faults = tuple(sorted(self._bank.faults))
        named = {kind: [name for result in results for name in getattr(result, kind)] for kind in SENTENCES}
        notes += [words.format(" and ".join(named[kind])) for kind, words in SENTENCES.items() if named[kind]]
        notes += [self._verdict] * bool(self._verdict)
        if not faults:
            self._verdict = ""
        suspects = tuple(dict.fromkeys([*(name for name in faults if name != MODEL), *named["suspects"]]))
        return Estimate(
            t, self.filter.states, joint, ready, nis, tuple(named["refused"]), suspects, tuple(notes), faults
        )


def smoothed_track(filter: ShipFilter, records: "pd.DataFrame", notes: tuple[str, ...]) -> EstimatedTrack:
    """Return states by all readings, before and after; where the estimate lay in a bank it begins anew."""
    # The coefficients are states too, with the fit's covariance as prior: a whole record may correct them.
    joint, count, size = replace(filter, coefficients="estimated", memory=math.inf), len(records), len(filter.states)
    refused, suspected = ({name: np.zeros(count, bool) for name in filter.sensors} for _ in range(2))
    rest = dict(zip(filter.actuators, joint.at_rest, strict=True))
    held = records[list(filter.actuators)].ffill().fillna(rest).to_numpy()
    start, run, runs = Start(joint), None, list[tuple[FilterRun, dict[float, int]]]()  # Each with its times and rows
    for row, (t, readings) in enumerate(rows_of(records, filter.sensors, ())):
        if run and not run.update(t, readings, held[row], []):
            notes, run, start = (*notes, AGROUND.format(t)), None, Start(joint)
        if run is None:
            for name, reading in readings.items():
                start.add(t - filter.sensors[name].delay, {name: reading})
            if start.missing:
                continue
            run = FilterRun(joint, [Moment(t, start.state(t), held[row], {}, joint.monitor())], math.inf, math.inf)
            runs.append((run, {}))
        for result in run.results:
            for flags, names in ((refused, result.refused), (suspected, result.suspects)):
                for name in names:
                    flags[name][row] = True
        runs[-1][1][t] = row
    if not runs:
        raise start.refusal()
    mean, covariance = np.full((count, size), np.nan), np.full((count, size, size), np.nan)
    for run, rows in runs:
        back = smoothed([step for moment in run.history for step in moment.steps], run.last.state)
        until = np.cumsum([len(moment.steps) for moment in run.history])
        for moment, place in zip(run.history, until, strict=True):
            if (row := rows.get(moment.t, -1)) >= 0:
                mean[row], covariance[row] = back[place][0][:size], back[place][1][:size, :size]
    known = np.isfinite(mean[:, 0])
    mean[:, 2] = (mean[:, 2] + np.pi) % (2 * np.pi) - np.pi
    refused, suspected = ({name: flag[known] for name, flag in by.items()} for by in (refused, suspected))
    t, ready = records.index.to_numpy()[known], np.ones(known.sum(), bool)
    return EstimatedTrack(
        t, mean[known], covariance[known], filter.states.names, ready, refused, suspected, True, notes
    )


def smoothed(steps: Sequence[MotionStep], last: Gaussian) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return means and covariances at the start of each step of the filter and at the end of the last."""
    # Rauch, Tung and Striebel (1965), Maximum likelihood estimates of linear dynamic systems. Sarkka (2008), Unscented
    # Rauch-Tung-Striebel smoother.
    mean, covariance = last.mean, last.covariance
    found = [(mean, covariance)]
    for step in reversed(steps):
        size = step.before.root.shape[1]
        # Columns of the root after those of the state are disturbances: their effect is in the state after.
        shared = step.before.root @ step.slopes[:size]
        ahead = step.state.covariance
        gain = np.linalg.lstsq(ahead, shared.T, rcond=None)[0].T
        mean = step.before.mean + gain @ (mean - step.state.mean)
        covariance = step.before.covariance + gain @ (covariance - ahead) @ gain.T
        covariance = (covariance + covariance.T) / 2
        found.append((mean, covariance))
    return found[::-1]


TIME = "t"


def records_of(table: Any, sensors: Mapping[str, Sensor], actuators: Sequence[str]) -> "pd.DataFrame":
    """Return a column for each field and each actuator, NaN without readings, over rising times."""
    import pandas as pd

    try:
        frame = pd.DataFrame(table.to_dataframe() if hasattr(table, "to_dataframe") else table)
        frame = (frame.reset_index() if frame.index.name == TIME else frame).astype(float)
    except (TypeError, ValueError):
        raise InputError(
            "records are columns of numbers of one length; give a DataFrame, a Dataset or a mapping, with NaN for none"
        ) from None
    known = [TIME, *(field for sensor in sensors.values() for field in sensor.fields), *actuators]
    for name in frame.columns:
        if name not in known:
            raise InputError(f"no sensor of this estimator has a column {name!r}{did_you_mean(str(name), known)}")
    if TIME not in frame:
        raise InputError("records need their times; give a column t [s]")
    t = frame[TIME].to_numpy()
    if len(t) == 0 or not np.isfinite(t).all() or (np.diff(t) <= 0.0).any():
        raise InputError("times of records are finite and rise; sort them, and merge rows of one time")
    return frame.reindex(columns=known).set_index(TIME)


def rows_of(
    records: "pd.DataFrame", sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> Iterator[tuple[float, dict[str, tuple[float, ...]]]]:
    """Yield each time with its readings, and positions of actuators, without NaN."""
    fields = {**{name: list(sensor.fields) for name, sensor in sensors.items()}, **{name: [name] for name in actuators}}
    columns = {name: records[own].to_numpy() for name, own in fields.items()}
    for number, t in enumerate(records.index.tolist()):
        now = {name: column[number] for name, column in columns.items()}
        yield t, {name: tuple(row.tolist()) for name, row in now.items() if np.isfinite(row).all()}


def checked_readings(
    readings: Mapping[str, Any], sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> tuple[dict[str, tuple[float, ...]], dict[str, float], list[str]]:
    """Split readings into those of sensors and of actuators, without NaN, and a note on invalid ones."""
    measured: dict[str, tuple[float, ...]] = {}
    positions: dict[str, float] = {}
    lost, known = [], (*sensors, *actuators)
    for name, reading in readings.items():
        if name not in known:
            raise InputError(f"no sensor of this estimator is called {name!r}{did_you_mean(name, known)}")
        numbers = _numbers(name, reading, len(sensors[name].fields) if name in sensors else 1)
        if not all(map(math.isfinite, numbers)):
            lost.append(name)
        elif name in sensors:
            measured[name] = numbers
        else:
            positions[name] = numbers[0]
    notes = [f"The reading of {' and '.join(lost)} is not a number and was not used."] if lost else []
    return measured, positions, notes


def _numbers(name: str, reading: Any, count: int) -> tuple[float, ...]:
    if count == 1 and isinstance(reading, float):  # Fast path for the most frequent case
        return (reading,)
    try:
        numbers = tuple(np.asarray(math.nan if reading is None else reading, float).ravel().tolist())
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != count and reading is not None:
        raise InputError(f"a reading of {name} is {count} number(s), and this one is {reading!r}; give as many")
    return numbers
