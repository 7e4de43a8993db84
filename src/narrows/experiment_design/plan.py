"""``plan_tests``: a ship, a tank and a budget of runs in; the runs and what they would tell out."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.captive.runs import HarmonicRun, Run, StraightRun
from narrows.captive.synthetic import NOISE
from narrows.captive.tests import CaptiveTests, Tests
from narrows.errors import InputError
from narrows.experiment_design.candidates import Tank, candidates
from narrows.experiment_design.information import run_information
from narrows.experiment_design.optimal import CRITERIA, RIDGE, choose
from narrows.identification.fitting import check_one_condition
from narrows.identification.regression.accumulation import accumulate
from narrows.identification.regression.problem import reduced, slots
from narrows.ship.particulars import Configuration
from narrows.terms.canal_tables import PAPER
from narrows.terms.term import TermTable

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class Plan:
    """Runs to make, and what they would tell.

    Parameters
    ----------
    runs : tuple of Run
        In the order in which they help.
    targets : tuple of str
        The coefficients that they are chosen for.
    std : mapping of str to array (runs,)
        Predicted standard error of each of them after each run, in the coefficient's unit; infinite before it is known.
    inflation : mapping of str to float [1]
        Variance inflation of each target's column under all runs.
    usual : mapping of str to float
        Predicted standard errors of the best plan of as many harmonic runs about the centreline.
    usual_inflation : mapping of str to float [1]
        Variance inflation under that plan.
    considered : int
        How many runs there were to choose from.
    notes : tuple of str
        Noise and length of a run, that the standard errors rest on.
    """

    runs: tuple[Run, ...]
    targets: tuple[str, ...]
    std: Mapping[str, np.ndarray]
    inflation: Mapping[str, float]
    usual: Mapping[str, float]
    usual_inflation: Mapping[str, float]
    considered: int
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Plan of {len(self.runs)} runs of {self.considered} for {', '.join(self.targets)}>"

    @property
    def determined(self) -> bool:
        """Whether the runs determine every target at all."""
        return all(np.isfinite(self.std[name][-1]) for name in self.targets)

    def summary(self) -> str:
        """Say what is gained, for each target: a line each."""
        unknown = [name for name in self.targets if not np.isfinite(self.std[name][-1])]
        gains = tuple(
            f"{name}: standard error {self.std[name][-1]:.2g} (VIF {self.inflation[name]:.3g}) with these runs, "
            f"{self.usual[name]:.2g} (VIF {self.usual_inflation[name]:.3g}) with as many of the best harmonic runs "
            "about the centreline."
            for name in self.targets
            if name not in unknown
        )
        lost = (f"No such runs determine {', '.join(unknown)}: allow more depths, speeds or runs.",) * bool(unknown)
        return "\n".join((*gains, *lost))

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name: what ``plan --json`` prints."""
        return {
            "runs": self.rows(),
            "targets": {
                name: {
                    "std": float(self.std[name][-1]),
                    "vif": self.inflation[name],
                    "usual_std": self.usual[name],
                    "usual_vif": self.usual_inflation[name],
                }
                for name in self.targets
            },
            "considered": self.considered,
            "summary": self.summary(),
            "notes": list(self.notes),
        }

    def rows(self) -> list[dict[str, Any]]:
        """One row a run, with the standard errors once it is made."""
        errors = [{f"std {name}": float(self.std[name][i]) for name in self.targets} for i in range(len(self.runs))]
        return [_row(run) | after for run, after in zip(self.runs, errors, strict=True)]

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the runs as a table: a row each, with the standard errors once it is made."""
        import pandas as pd

        return pd.DataFrame(self.rows())


def _row(run: Run) -> dict[str, Any]:
    values = asdict(run) if isinstance(run, HarmonicRun | StraightRun) else {"name": run.name}
    drift = {"drift_deg": float(np.degrees(values.pop("drift")))} if "drift" in values else {}
    return {"kind": "straight", **values, **drift, "duration": run.duration}


def plan_tests(
    configuration: Configuration, runs: int = 12, *, tank: Tank | None = None, terms: TermTable = PAPER,
    targets: Sequence[str] = (), criterion: str = "c", noise: Mapping[str, float] = NOISE,
    correlation_time: float = 0.5, after: Tests | None = None,
) -> Plan:  # fmt: skip
    """Choose the runs that make some coefficients best known, all others being unknown too.

    Parameters
    ----------
    configuration : Configuration
        Ship, canal and water.
    runs : int
        How many.
    tank : Tank, optional
        What the tank can do.
    terms : TermTable
        The terms that are to be identified.
    targets : sequence of str
        The coefficients that matter; those of the bank unless given.
    criterion : str
        ``c``: the sum of their variances, each over that of the best single run for it; ``d``: the determinant of
        their covariance.
    noise : mapping of str to float [N, N, N m]
        Standard deviation of each force.
    correlation_time : float [s]
        Of the noise.
    after : CaptiveTests, optional
        Tests that were made already.

    Returns
    -------
    Plan
        The runs and their gain.

    Raises
    ------
    InputError
        Where there is no run to choose, a target is unknown, or the terms ask for what the ship file lacks.
    """
    tank = tank or Tank()
    _check(runs, criterion, terms, noise, tank)
    names = _targets(terms, targets)
    offered = candidates(configuration, tank)
    adds = np.array([run_information(run, configuration, terms, noise, correlation_time) for run in offered])
    known = _known(after, terms, noise, correlation_time) if after is not None else np.zeros(adds.shape[1:])
    index = [slots(terms)[name] for name in names]
    parameters = sorted(set(index))  # tied coefficients are one
    best = choose(adds, known, runs, parameters, criterion)
    centred = adds[[isinstance(run, HarmonicRun) and run.offset == 0 for run in offered]]
    usual = choose(centred, known, len(best), parameters, criterion)
    std, inflation = _predicted(known + np.cumsum(adds[best], axis=0), index)
    usual_std, usual_inflation = _predicted((known + centred[usual].sum(axis=0))[None], index)
    return Plan(
        tuple(offered[i] for i in best),
        names,
        dict(zip(names, std.T, strict=True)),
        dict(zip(names, inflation[-1].tolist(), strict=True)),
        dict(zip(names, usual_std[0].tolist(), strict=True)),
        dict(zip(names, usual_inflation[0].tolist(), strict=True)),
        len(offered),
        (_assumed(noise, correlation_time, tank, configuration),),
    )


def _check(runs: int, criterion: str, terms: TermTable, noise: Mapping[str, float], tank: Tank) -> None:
    if runs < 1:
        raise InputError(f"{runs} runs are no plan; ask for one or more")
    if criterion not in CRITERIA:
        raise InputError(f"criterion {criterion!r} is unknown; choose {' or '.join(CRITERIA)}")
    for force, part in terms.forces.items():
        if part and not noise.get(force, 0.0) > 0:
            raise InputError(f"noise: {force} needs a positive standard deviation; give one for each force")
    if tank.depths and not terms.feels_depth:
        raise InputError("these terms do not know the depth of the water; leave the depths out, or take terms that do")


def _assumed(noise: Mapping[str, float], correlation_time: float, tank: Tank, configuration: Configuration) -> str:
    sizes = ", ".join(f"{size:g} {'N m' if force == 'N' else 'N'} in {force}" for force, size in noise.items())
    return (
        f"Assumed: noise of {sizes}, correlated over {correlation_time:g} s; {tank.length_for(configuration):g} m of "
        "steady motion a run."
    )


def _targets(terms: TermTable, targets: Sequence[str]) -> tuple[str, ...]:
    names = (targets,) if isinstance(targets, str) else tuple(targets)
    names = names or tuple(term.name for term in terms.terms if term.from_bank)
    for name in names:
        if name not in terms.names:
            raise InputError(f"the terms have no {name!r}; targets are {', '.join(terms.names)}")
    if not names:
        raise InputError("these terms have no bank to plan for; name the coefficients that matter as targets")
    return names


def _predicted(information: np.ndarray, index: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Standard errors and variance inflations of some parameters, (steps, targets); infinite while unknown."""
    diagonal = np.diagonal(information, axis1=1, axis2=2)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = information / (size[:, :, None] * size[:, None, :]) + RIDGE * np.eye(information.shape[-1])
    inflation = np.diagonal(np.linalg.inv(scaled), axis1=1, axis2=2)[:, index]
    inflation = np.where(inflation > 1e-2 / RIDGE, np.inf, inflation)
    return np.sqrt(inflation) / size[:, index], inflation


def _known(tests: Tests, terms: TermTable, noise: Mapping[str, float], correlation_time: float) -> np.ndarray:
    """Information of tests that were made; rows nearer in time than two correlation times share theirs."""
    check_one_condition(tests, terms)
    equations, _ = accumulate(tests, terms)
    problem = reduced(equations, terms)
    weighed = replace(problem, weights={force: 1 / noise[force] ** 2 for force, part in terms.forces.items() if part})
    share = np.array([1 / max(1.0, 2 * correlation_time * _rate(tests, name)) for name in equations.names])
    h, _ = weighed.normal(np.tensordot(share, equations.by_test(), axes=1))
    return np.asarray(h * np.outer(problem.scale, problem.scale))


def _rate(tests: Tests, name: str) -> float:
    """Of sampling [Hz]; 0 where the rows carry no time, so that each is taken as independent."""
    t = tests.test(name).get("t") if isinstance(tests, CaptiveTests) else None
    return 0.0 if t is None or len(t) < 2 else float(1 / np.median(np.diff(t)))
