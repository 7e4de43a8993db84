"""Learn a model from a ship's own records: ``learn``."""

import hashlib
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.progress import stage
from narrows.logbook.filtering.likelihood import LOOSE_WALK, SearchResult, search
from narrows.logbook.filtering.log_problem import SWAY, YAW, LogProblem
from narrows.logbook.filtering.record_grid import HELM, OFFSET, RUDDER
from narrows.logbook.learned_coefficients import LogPosterior, Spread, averaged, learned_model, log_posterior
from narrows.logbook.learning.log_fit import Gusts, LogFit, SignalNoise, record_answers
from narrows.logbook.learning.log_setup import LogSetup, log_problem
from narrows.logbook.ship_log import SensorGrade, ShipLog, ShipRecord
from narrows.model.model import Model
from narrows.model.sections import Source
from narrows.waterway import Waterway

STRETCHES = "The model was fitted to short stretches of the records. Do not predict whole manoeuvres with it."


@accept_aliases
def learn(
    model: Model, log: Any, *, free: Sequence[str] = (), sensors: str | SensorGrade = "vdr",
    spread: Spread | None = None, gusts: bool | None = None, asymmetry: bool | None = None,
    waterway: Waterway | None = None, **choices: Any,
) -> LogFit:  # fmt: skip
    """Learn from what a ship did under its own helm: zigzags, turning circles, transits of a canal.

    The coefficients maximise the likelihood of the errors of a Kalman filter (innovations) and the prior, under the
    recorded rudder. In gusts the answer is the mean of two fits, one with the rudder as given, one with the rudder as
    readings of a pilot's linear law. Motion determines forces over inertia alone: the prior of the inertia holds the
    rest. Ctrl-C ends the search and keeps what was found.

    Raises an InputError where the model has neither covariance nor spread, a name is unknown, or no record can be used.

    Parameters
    ----------
    model, log : Model; ShipLog, StreamedLog, ShipRecord, sequence of records, table, voyage or path
        A model at the ship's own size with the covariance of its fit, which is the prior; what was recorded.
    free : sequence of str, optional
        Coefficients that may change, all that have a spread unless given. The others keep their mean and covariance,
        and their errors are part of the standard errors of the free ones (Schmidt's Kalman update).
    sensors : {"rtk", "vdr", "ais", "basin"} or SensorGrade
        How well it was measured; in a basin, noise is estimated and no wind blows.
    spread : float or mapping of str to float, optional
        Prior of a model without a covariance: standard deviations over the size of coefficients, inertia held, or
        each in its own unit.
    gusts, asymmetry : bool, optional
        Whether gusts act, by default in all but a basin; whether asymmetries of hull and rudder are learned, by default
        where no gusts act and ``free`` names nothing.
    waterway : Waterway, optional
        Line of x and y; the one of the log, or else the model's own canal.
    **choices : Any
        As for ``simulate``: surge (``free`` with a propeller, unless the logged speed never changes), surge_inertia,
        coriolis.
    """
    posed = partial(log_problem, model, log, sensors, free=free, spread=spread, gusts=gusts, asymmetry=asymmetry,
                    waterway=waterway, **choices)  # fmt: skip
    setup = posed()
    with stage("fitting the records"):
        found = search(setup.problem, setup)
    if found is None:
        raise InputError("the model cannot follow this log: its motion goes to infinity; look at it with `check_log`")
    if not found.records:
        why = " ".join(setup.left_out).removesuffix(".") or "it has none"
        raise InputError(f"no record of this log can be used: {why}")
    piloted = None
    if setup.gusts and RUDDER in setup.problem.motion.positions and not found.interrupted:
        joint = posed(pilot=True)
        with stage("fitting the records with a pilot"):
            piloted = search(joint.problem, joint, scaled=found.scaled)
    return log_result(setup, found, free, piloted)


def _source(log: Iterable[ShipRecord], sensors: str, records: int) -> Source:
    """Return the provenance, with the hash of names, times and values."""
    hashed = hashlib.sha256()
    for record in log:
        for key in record:
            hashed.update(f"{record.name} {key}".encode())
            hashed.update(np.stack([record[key].t, record[key].values]).tobytes())
    name, sha256 = Path(str(getattr(log, "name", "a log"))).name, hashed.hexdigest()
    if isinstance(log, ShipLog):
        name = " to ".join(dict.fromkeys((log.names[0], log.names[-1])))
    about = f"{name}, sensors {sensors}, sha256 {sha256[:12]}..."
    return Source(f"learned from {records} record{'s' * (records > 1)} of the ship itself ({about})", name, sha256)


def log_result(
    posed: LogSetup, found: SearchResult, free: Sequence[str], piloted: SearchResult | None = None
) -> LogFit:
    """Return the answer of a search, averaged with that of one with a pilot where there is one."""
    prior = posed.problem.prior.model
    after = _posterior(found)
    apart: tuple[str, ...] = ()
    if piloted is not None and piloted.records and not (piloted.diverged or piloted.interrupted):
        given, joint = after, _posterior(piloted)
        after, apart = averaged(given, joint), rudder_matters(prior, given, joint)
    answers = record_answers(found, posed)
    ranges = np.stack([one.ranges for one in found.records]).T
    source = _source(posed.log, posed.grade.name, len(answers))
    model, learned = learned_model(prior, after, source, *ranges)
    stopped = f"The search was interrupted after {found.steps} steps; the result is from {len(answers)} records."
    assumed = _assumptions(found.problem, free)
    about = (*apart, *(STRETCHES,) * (found.problem.walk == LOOSE_WALK), *assumed, *posed.left_out,
             *(stopped,) * found.interrupted)  # fmt: skip
    return LogFit(
        model, prior, learned, answers, _gusts(found), _noise(found), after.disagreement, after.freedom,
        after.probability, about, found.converged,
    )  # fmt: skip


def _posterior(found: SearchResult) -> LogPosterior:
    scores = np.stack([one.score for one in found.records])
    return log_posterior(found.problem, found.unknowns, found.information, scores)


def rudder_matters(model: Model, given: LogPosterior, joint: LogPosterior) -> tuple[str, ...]:
    """Return the bank coefficients that depend on whether the rudder is an input or the order of a pilot."""
    # Hausman (1978), Specification tests in econometrics, Econometrica 46: of the two only the second is consistent
    # where the pilot sees more than the log.
    return tuple(
        f"{name} is {one:.3g} if the rudder is taken as given and {other:.3g} with a pilot's law, more than a standard "
        "error apart: the pilot may see more than the log. Its interval includes both."
        for name, one, other, variance in zip(
            model.terms.names, given.values, joint.values, np.diag(given.covariance), strict=True
        )
        if model.terms[name].from_bank and abs(one - other) > math.sqrt(variance)
    )


def _gusts(found: SearchResult) -> Gusts | None:
    problem, model = found.problem, found.problem.model_at(found.unknowns)
    if SWAY not in model.gusts:
        return None
    usual, now = ({one.name: one for one in each.processes} for each in (problem.model, model))
    strength = max(now[name].std / usual[name].std for name in (SWAY, YAW))
    return Gusts(now[SWAY].std, now[YAW].std, now[SWAY].memory, model.correlation, float(strength))


def _noise(found: SearchResult) -> dict[str, SignalNoise]:
    noise = found.problem.model_at(found.unknowns).noise
    counts = {name: np.sum([one.outliers.get(name, (0, 0)) for one in found.records], axis=0) for name in noise}
    return {
        name: SignalNoise(size, float(counts[name][0] / max(counts[name][1], 1)))
        for name, size in noise.items() if name != HELM
    }  # fmt: skip


def _assumptions(problem: LogProblem, free: Sequence[str]) -> Iterator[str]:
    if free:
        yield f"Only {', '.join(free)} may change. Their intervals include the errors of the fixed coefficients."
    model = problem.motion.model
    if model.has_bank:
        deep = model.configuration.canal.depth
        depth = f"a depth of {deep:.3g} m" if deep else "a depth that is not known"
        depth = "the waterway's depths" if "waterway" in problem.motion.choices else depth
        yield (
            f"Assumed: a draft of {model.configuration.ship.draft:.3g} m, {depth}, and charted banks with one offset "
            "to each record. At another depth or draft, which a transit does not show, the intervals are too narrow."
        )
    yield from model.configuration.notes
    if any(one.adds_to == OFFSET("revolutions") for one in problem.model.processes):
        yield (
            "The log has no propeller revolutions: each record has an unknown number of them about those that keep the "
            "usual speed. The rudder's force depends on them; record them."
        )
