"""The estimator: where a ship is, how it moves, and what banks, current and gear do to it, from readings."""

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from narrows.codegen.free_motion import Surge
from narrows.errors import InputError, check_choice
from narrows.estimation.estimate import Estimate, EstimatedTrack
from narrows.estimation.records import Moment, Reading, checked_readings, records_of
from narrows.estimation.recursion import UpdateResult
from narrows.estimation.settings import COEFFICIENT_MEMORY, LONGEST_GAP, SAME_TIME, SILENT_PERIODS
from narrows.estimation.ship_filter import Coefficients, ShipFilter, default_step, split_sensors
from narrows.estimation.smoothing import smooth
from narrows.estimation.states import Prior, ProcessNoise
from narrows.estimation.unscented import Gaussian
from narrows.model.model import Model
from narrows.results import Described

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


class Estimator(Described):
    """A square-root unscented filter of a ship in a canal or a waterway, in real time.

    Usually it corrects the model's coefficients along with the state, from the covariance of the fit: a filter that
    trusts its coefficients looks right by its innovations where its state is wrong. What it learned of them fades.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    sensors : sequence of Sensor and RudderIndicator
        What measures: ``Gnss``, ``Gyro``, ``RateOfTurn``, ``Log``, ``CourseOverGround``, ``RudderIndicator``, or
        objects of your own that keep to ``Sensor``.
    waterway : Waterway, optional
        Where it sails instead of the model's own canal.
    noise : ProcessNoise, optional
        How fast the motion wanders from the model; by the ship's length unless given.
    prior : Prior, optional
        What is believed before any reading; by the ship's length unless given.
    coefficients : {"considered", "certain", "estimated"}
        Whether the uncertainty of the coefficients, where the model has their covariance, is corrected by the readings;
        carried and never corrected (Schmidt's consider form), in a fraction of the time; or left out.
    memory : float [s]
        Time in which what readings tell of the coefficients fades back to the fit, for the model's form is not certain
        either; ``math.inf``: never.
    refusing : float [1]
        Probability with which a gate refuses a sound reading; 0 for no gates.
    step : float [s], optional
        Longest step of the motion; a quarter of the root of length over gravity unless given.
    surge : {"held", "free"}
        ``held``: the speed wanders as a random walk; ``free``: by the model too.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force.

    Raises
    ------
    InputError
        Where a sensor is none, two share a name, or a number is none.

    References
    ----------
    van der Merwe and Wan (2001), The square-root unscented Kalman filter for state and parameter estimation.
    Schmidt (1966), Application of state-space methods to navigation problems.
    """

    def __init__(
        self, model: Model, sensors: Sequence[Any], *, waterway: "Waterway | None" = None,
        noise: ProcessNoise | None = None, prior: Prior | None = None, coefficients: Coefficients = "estimated",
        memory: float = COEFFICIENT_MEMORY, refusing: float = 1e-5, step: float | None = None,
        surge: Surge = "held", surge_inertia: float | None = None, coriolis: bool = False,
    ) -> None:  # fmt: skip
        check_choice("coefficients", coefficients, get_args(Coefficients))
        length = model.configuration.ship.length
        by_name, indicator = split_sensors(sensors)
        self.filter = ShipFilter(
            model, by_name, indicator, waterway, noise or ProcessNoise.of_length(length),
            prior or Prior.of_length(length), coefficients, refusing,
            default_step(model) if step is None else float(step), float(memory), surge, surge_inertia, coriolis,
        )  # fmt: skip
        self._horizon = max(sensor.late for sensor in by_name.values())
        self._last: Gaussian | None = None
        values = self.filter.ship.values()
        self._at_rest = np.array([float(values.get(name) or 0.0) for name in self.filter.actuators])
        self._begin_anew()

    def _begin_anew(self) -> None:
        self._start = self.filter.start()
        self._history: list[Moment] = []
        self._heard: dict[str, float] = {}

    def forget(self) -> None:
        """Begin anew, as if nothing had come in yet."""
        self._last = None
        self._begin_anew()

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know before the estimates are used."""
        model = self.filter.model
        why = "The model has no covariance of its coefficients, so the estimate takes them for certain."
        return (*model.bank_notes, *((why,) if model.covariance is None else ()))

    def summary(self) -> str:
        """Say what is estimated from what."""
        filter = self.filter
        return (
            f"{', '.join(filter.states.names)} of {filter.model.configuration.ship.name} by {', '.join(filter.sensors)}"
        )

    def update(self, t: float, readings: Mapping[str, Any] | None = None, **named: Reading) -> Estimate:
        """Take what came in at a time, and return the estimate at that time.

        A reading is as old as its sensor is late; one that is older than what is known already is put where it belongs
        and what came after it is done again. NaN is a reading that did not come. The rudder's angle and the propeller's
        revolutions stay what they were until they are told anew.

        Parameters
        ----------
        t : float [s]
            Now.
        readings : mapping of str to float or sequence of float, optional
            By the names of sensors and actuators: ``{"gnss": (x, y), "gyro": psi, "rudder": angle}``, SI and rad.
        **named : float or sequence of float
            The same by keyword.

        Returns
        -------
        Estimate
            Finite numbers whatever came in; what was wrong with it is in its ``notes``.

        Raises
        ------
        InputError
            Where the time is no number, or a reading is of no sensor, or not of as many numbers as the sensor's.
        """
        if not math.isfinite(t):
            raise InputError(f"t = {t} is no time; give seconds")
        told = checked_readings({**(readings or {}), **named}, self.filter.sensors, self.filter.actuators)
        notes = list(told.notes)
        gap = t - self._history[-1].t if self._history else 0.0
        if abs(gap) > LONGEST_GAP:
            what = f"Nothing came for {gap:.0f} s" if gap > 0.0 else f"The time went back by {-gap:.0f} s"
            notes.append(f"{what}: the estimate begins anew.")
            self._begin_anew()
        if not self._history:
            return self._waited(float(t), told.measured, told.positions, notes)
        return self._went_on(float(t), told.measured, told.positions, notes)

    def run(self, records: Any) -> EstimatedTrack:
        """Estimate a whole record as it would have been in real time; it begins anew.

        Parameters
        ----------
        records : DataFrame, Dataset or mapping of str to array
            A row a time: ``t`` [s], the fields of the sensors (``gnss_x``, ``gnss_y``, ``gyro`` ...) and positions of
            actuators (``rudder`` [rad], ``revolutions`` [1/s]); NaN where nothing came in.

        Returns
        -------
        EstimatedTrack
            From the first time at which there was enough to start from.

        Raises
        ------
        InputError
            Where a column belongs to nothing, times do not rise, or there is never enough to start from.
        """
        told = records_of(records, self.filter.sensors, self.filter.actuators)
        self.forget()
        found = [self.update(t, {**readings, **positions}) for t, readings, positions in told.rows()]
        known = [estimate for estimate in found if estimate.normal is not None]
        if not known:
            raise InputError(
                f"no row of these records tells {self._start.lacking}; an estimate starts from all of them"
            )
        flags = [
            {name: np.array([name in said(estimate) for estimate in known]) for name in self.filter.sensors}
            for said in (attrgetter("refused"), attrgetter("suspects"))
        ]
        mean = np.array([list(estimate.values.values()) for estimate in known])
        covariance = np.array([estimate.covariance for estimate in known])
        begun = dict.fromkeys(note for estimate in known for note in estimate.notes if note.endswith("begins anew."))
        return EstimatedTrack(
            np.array([estimate.t for estimate in known]), mean, covariance, self.filter.states.names,
            np.array([estimate.ready for estimate in known]), flags[0], flags[1], False, (*self.notes, *begun),
        )  # fmt: skip

    def smooth(self, records: Any) -> EstimatedTrack:
        """Estimate a whole record after the fact: each state by all readings, before and after it.

        The uncertain coefficients are estimated along with the states, with the fit's covariance before.

        Parameters
        ----------
        records : DataFrame, Dataset or mapping of str to array
            As for ``run``.

        Returns
        -------
        EstimatedTrack
            At the times of the record from the first at which there was enough to start from.

        Raises
        ------
        InputError
            As for ``run``.
        """
        told = records_of(records, self.filter.sensors, self.filter.actuators)
        found = smooth(self.filter, told)
        known = np.isfinite(found.mean[:, 0])
        mean = found.mean[known]
        mean[:, 2] = (mean[:, 2] + np.pi) % (2 * np.pi) - np.pi
        flags = [{name: flag[known] for name, flag in by.items()} for by in (found.refused, found.suspected)]
        resets = [
            f"At t = {t:g} s the estimate lay in a bank or beyond the waterway: it begins anew." for t in found.resets
        ]
        return EstimatedTrack(
            told.t[known], mean, found.covariance[known], self.filter.states.names, np.ones(int(known.sum()), bool),
            flags[0], flags[1], True, (*self.notes, *resets),
        )  # fmt: skip

    def _waited(
        self, t: float, measured: dict[str, tuple[float, ...]], positions: dict[str, float], notes: list[str]
    ) -> Estimate:
        start = self._start
        for name in [name for name, heard in self._heard.items() if self._quiet(name, t - heard)]:
            start.readings.pop(name, None)  # Too old to start from.
        start.readings.update(measured)
        self._heard.update(dict.fromkeys(measured, t))
        if start.lacking:
            notes.append(f"No sensor has told {start.lacking} yet, so there is nothing to start from.")
            return self._estimate(t, self._last, False, notes)
        late = max((self.filter.sensors[name].late for name in measured), default=0.0)
        at = self._at_rest.copy()
        for number, name in enumerate(self.filter.actuators):
            at[number] = positions.get(name, at[number])
        first = self.filter.begin(start)
        self._history = [Moment(t - late, first, at, {}, self.filter.monitor())]
        return self._went_on(t, {}, positions, notes)

    def _went_on(
        self, t: float, measured: dict[str, tuple[float, ...]], positions: dict[str, float], notes: list[str]
    ) -> Estimate:
        last = self._history[-1]
        if t < last.t - SAME_TIME:
            notes.append(f"The time went back from {last.t:g} to {t:g} s: what came is taken for late.")
        now = max(t, last.t)
        at = last.positions.copy()
        for number, name in enumerate(self.filter.actuators):
            at[number] = positions.get(name, at[number]) if t >= last.t - SAME_TIME else at[number]
        heard: list[UpdateResult] = []
        self._heard.update(dict.fromkeys(measured, now))
        if t > last.t + SAME_TIME and not self._horizon:
            afloat = self._advanced(t, at, measured, heard)
            del self._history[:-1]
        else:
            afloat = self._put(t, now, measured, at, heard, notes)
        if not afloat:
            notes.append(f"At t = {t:g} s the estimate lay in a bank or beyond the waterway: it begins anew.")
            self._begin_anew()
            return self._waited(t, measured, positions, notes)
        self._last = self._history[-1].normal
        return self._estimate(now, self._last, True, [*notes, *self._silences(now)], heard)

    def _put(
        self, t: float, now: float, measured: dict[str, tuple[float, ...]], at: np.ndarray, heard: list[UpdateResult],
        notes: list[str],
    ) -> bool:  # fmt: skip
        """Take readings in the order in which they were measured; False where the mean of the state met a bank."""
        groups: dict[float, dict[str, tuple[float, ...]]] = {}
        for name, reading in measured.items():
            groups.setdefault(t - self.filter.sensors[name].late, {})[name] = reading
        groups.setdefault(now, {})
        for time in sorted(groups):
            if not self._taken(time, groups[time], at, now, heard, notes):
                return False
        # No reading can be older than the horizon.
        while len(self._history) > 1 and self._history[1].t <= now - self._horizon + SAME_TIME:
            del self._history[0]
        return True

    def _taken(
        self, time: float, readings: dict[str, tuple[float, ...]], at: np.ndarray, now: float,
        heard: list[UpdateResult], notes: list[str],
    ) -> bool:  # fmt: skip
        """Take readings of one time where they belong; False where the mean of the state met a bank."""
        history = self._history
        place = bisect_right(history, time + SAME_TIME, key=lambda moment: moment.t)
        if place == 0:
            late = ", ".join(readings)
            notes.append(f"What {late} told is from t = {time:g} s, before anything that is kept: it is passed over.")
            return True
        later, base = history[place:], history[place - 1]
        del history[place:]
        ahead_t, ahead = (later[0].t, later[0].positions) if later else (now, at)
        share = 1.0 if ahead_t - base.t <= SAME_TIME else min(1.0, (time - base.t) / (ahead_t - base.t))
        positions = base.positions + share * (ahead - base.positions)
        if not self._advanced(time, positions, readings, heard):
            return False
        return all(self._advanced(moment.t, moment.positions, moment.readings) for moment in later)

    def _advanced(
        self, time: float, positions: np.ndarray, readings: dict[str, tuple[float, ...]],
        heard: list[UpdateResult] | None = None,
    ) -> bool:  # fmt: skip
        """Go on from the last moment to a time and take readings there; False where the mean met a bank."""
        last = self._history[-1]
        normal, monitor, known = last.normal, last.monitor, last.readings
        if time - last.t > SAME_TIME:
            taken = self.filter.steps(normal, time - last.t, last.positions, positions)
            if taken[-1].aground:
                return False
            normal, known = taken[-1].normal, {}
        else:
            self._history.pop()
            time = last.t
        if readings:
            monitor = monitor.copy() if self._horizon else monitor
            believed = self.filter.recursion.update(normal, readings, monitor)
            normal = believed.normal
            if heard is not None:
                heard.append(believed)
        self._history.append(Moment(time, normal, positions, {**known, **readings}, monitor))
        return True

    def _silences(self, now: float) -> list[str]:
        silent = []
        for name in self.filter.sensors:
            quiet = now - self._heard.setdefault(name, now)
            if self._quiet(name, quiet):
                silent.append(f"{name} has told nothing for {quiet:.0f} s.")
        return silent

    def _quiet(self, name: str, time: float) -> bool:
        return not 0.0 <= time <= SILENT_PERIODS * self.filter.sensors[name].period

    def _estimate(
        self, t: float, normal: Gaussian | None, ready: bool, notes: list[str], heard: Sequence[UpdateResult] = ()
    ) -> Estimate:
        nis: dict[str, float] = {}
        for believed in heard:
            nis |= believed.nis
        refused = tuple(name for believed in heard for name in believed.refused)
        suspects = tuple(name for believed in heard for name in believed.suspects)
        if refused:
            notes.append(f"What {' and '.join(refused)} told is too far from what was expected: it is refused.")
        surprising = tuple(name for believed in heard for name in believed.surprising)
        if surprising:
            notes.append(f"What {' and '.join(surprising)} told is not what the model expects: the model errs.")
        if suspects:
            notes.append(f"What {' and '.join(suspects)} tells leans to one side: it drifts, or is led astray.")
        joint, size = normal, len(self.filter.states)
        state = None if joint is None else Gaussian(joint.mean[:size], joint.root[:size])
        return Estimate(t, self.filter.states, state, ready, nis, refused, suspects, tuple(notes), joint)
