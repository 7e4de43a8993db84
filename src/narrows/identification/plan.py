"""Optimal experiment design: ``plan_tests`` chooses the next runs, from a ship, a tank and a budget."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import special

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import Tabulated
from narrows.captive.read import as_tests
from narrows.captive.settings import FORCE_NOISE
from narrows.captive.synthetic import HarmonicRun, Run, StraightRun, Tank, candidates, twin
from narrows.empirical.fleet import published
from narrows.identification.estimates import HALF
from narrows.identification.fit import Fit
from narrows.identification.fitting import identify
from narrows.identification.least_squares import bounded_problem, free_parameters
from narrows.identification.mixed_model import MixedModel
from narrows.identification.motions import DistinctMotions, ForceRows, distinct_motions, row_blocks
from narrows.identification.normal_equations import ONE, NormalEquations, accumulate
from narrows.identification.systematic_effects import RunErrors, assemble
from narrows.identification.verdict import Diagnostics
from narrows.model.data_range import DataRange
from narrows.model.derived_models import scale_model
from narrows.model.model import Model
from narrows.model.tables import PAPER, with_bank
from narrows.model.term import TermTable
from narrows.ship.particulars import Configuration
from narrows.ship.ship_file import ShipSource, ship_from

if TYPE_CHECKING:
    import pandas as pd

# Units of the rows of a plan.
UNITS = {
    "offset": "m", "amplitude": "m", "period": "s", "speed": "m/s", "drift_deg": "deg", "depth": "m", "duration": "s",
}  # fmt: skip
# Number of straight runs at the start of a plan for the bank.
SEPARATING = 4


@dataclass(frozen=True, repr=False)
class Plan(Tabulated):
    """Planned runs and their expected information.

    >>> plan = nw.plan_tests(model.configuration, 4)
    >>> len(plan.runs)
    4
    """

    runs: tuple[Run, ...]  #: Runs in the order of their benefit
    targets: tuple[str, ...]  #: Target coefficients
    #: (runs,) Predicted standard error of each of them after each run, in the coefficient's unit; infinite before it
    #: is determined
    std: Mapping[str, np.ndarray]
    #: Predicted standard errors of the best plan of as many harmonic runs about the centreline
    usual: Mapping[str, float]
    considered: int  #: Number of candidate runs
    notes: tuple[str, ...]  #: Assumed noise and length of a run

    @property
    def reach(self) -> dict[str, float]:
        """Half of the 95 % interval of each target in a fit to all runs, in the coefficient's unit."""
        return {name: float(HALF * std[-1]) for name, std in self.std.items()}

    @property
    def determined(self) -> bool:
        """True if the runs determine every target."""
        return bool(np.isfinite(list(self.reach.values())).all())

    def summary(self) -> str:
        reach, lost = self.reach, [name for name in self.targets if not np.isfinite(self.std[name][-1])]
        lines = [
            f"{name}: standard error {self.std[name][-1]:.2g}, interval +- {reach[name]:.2g} with these runs; "
            f"{self.usual[name]:.2g} with as many of the best harmonic runs about the centreline."
            for name in self.targets if name not in lost
        ]  # fmt: skip
        if lost:
            lines.append(f"These runs do not determine {', '.join(lost)}: allow more depths, speeds or runs.")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        return {
            "runs": self.rows(),
            "targets": {
                name: {"std": float(self.std[name][-1]), "reach": reach, "usual_std": self.usual[name]}
                for name, reach in self.reach.items()
            },
            "considered": self.considered,
            "summary": self.summary(),
            "notes": list(self.notes),
        }

    def rows(self) -> list[dict[str, Any]]:
        """One row per run, with the standard errors after it."""
        rows = []
        for i, run in enumerate(self.runs):
            values = asdict(run) if isinstance(run, HarmonicRun | StraightRun) else {"name": run.name}
            if "drift" in values:
                values["drift_deg"] = float(np.degrees(values.pop("drift")))
            after = {f"std {name}": float(std[i]) for name, std in self.std.items()}
            rows.append({"kind": "straight", **values, "duration": run.duration, **after})
        return rows

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the runs as a table with units: one row each, with the standard errors after it."""
        import pandas as pd

        headers = {name: f"{name.removesuffix('_deg')} [{unit}]" for name, unit in UNITS.items()}
        return pd.DataFrame(self.rows()).rename(columns=headers)


@accept_aliases
def plan_tests(
    configuration: ShipSource, runs: int = 12, *, tank: Tank | None = None, terms: TermTable = PAPER,
    targets: Sequence[str] = (), noise: Mapping[str, float] = FORCE_NOISE,
    correlation_time: float = 0.5, after: Any = None, errors: RunErrors | None = None,
) -> Plan:  # fmt: skip
    """Choose runs that minimise the sum of the variances of some coefficients, each over that of its best single run.

    Runs differ by gain, zero and form, as in ``identify``; a zero shared by all runs is unknown too. The choice is the
    best under the worst of several forms of the bank. A plan for the bank begins with straight runs, mirrored to both
    sides: a hull force that changes with the period or the speed cannot imitate them.

    Raises an InputError if there is no candidate run, a target is unknown, or the terms need a quantity that the ship
    file lacks.

    Parameters
    ----------
    configuration : str, Path, Configuration or mapping
        Ship, canal and water: a ship file, its configuration, its sections as mappings, or a model; or earlier tests
        or their fit, to which the plan adds runs.
    runs : int
        Number of runs.
    tank : Tank, optional
        Limits of the tank.
    terms : TermTable
        Terms to identify.
    targets : sequence of str
        Target coefficients; those of the bank unless given.
    noise : mapping of str to float [N, N, N m]
        Standard deviation of each force.
    correlation_time : float [s]
        Correlation time of the noise.
    after : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset, optional
        Earlier tests; speeds and offsets stay within theirs unless the tank sets others.
    errors : RunErrors, optional
        Differences between runs beyond their noise; those of ``identify`` unless given.

    Examples
    --------
    >>> len(nw.plan_tests(model.configuration, 4).runs)
    4
    """
    tank, configuration = tank or Tank(), getattr(configuration, "tests", configuration)  # Those of a fit
    _check(runs, terms, noise, tank)
    after = configuration if after is None and hasattr(configuration, "blocks") else after
    configuration = ship_from(configuration, terms.actuators)
    names, errors = _targets(terms, targets), errors or RunErrors()
    tables = _forms(terms)
    done = None if after is None else as_tests(after, None, configuration)
    made = [] if done is None else [identify(done, table, errors=errors) for table in tables]
    tank, limits = within_tested(tank, made[0].data_range if made else None)
    offered = candidates(configuration, tank)
    assumed = ExpectedErrors(configuration, noise, correlation_time, errors)
    tests = twin(expected_model(configuration), tuple(offered), {}, rate=RATE)
    planned = [accumulate(tests, table)[0] for table in tables]
    adds = np.stack([assumed.information(sums, table) for sums, table in zip(planned, tables, strict=True)], axis=1)
    known = np.array([known_information(fit) for fit in made]) if made else np.zeros(adds.shape[1:])
    parameters = sorted({free_parameters(terms)[name] for name in names})  # tied coefficients are equal
    for_bank = any(term.from_bank and term.name in names for term in terms.terms)
    best = _separating(offered, adds, known, min(runs, SEPARATING) if for_bank else 0, parameters)
    rest = np.setdiff1d(np.arange(len(offered)), best)
    more = choose(adds[rest], known + adds[best].sum(axis=0), runs - len(best), parameters)
    best = [*best, *rest[more].tolist()]
    centred = [i for i, run in enumerate(offered) if isinstance(run, HarmonicRun) and run.offset == 0]
    # A tank too small for harmonic runs offers no other plan for comparison.
    best_harmonic = [centred[i] for i in choose(adds[centred], known, len(best), parameters)] or best
    given = (names, terms, assumed, made[0] if made else None)
    # In plans of more than 24 runs standard errors are those after some runs, repeated for the runs before.
    counts = np.unique(np.linspace(1, len(best), min(len(best), 24)).astype(int)).tolist()
    chosen, harmonic = (tuple(offered[i] for i in own) for own in (best, best_harmonic))
    std = expected_errors(planned[0], chosen, counts, *given)[np.searchsorted(counts, np.arange(1, len(best) + 1))]
    (usual,) = expected_errors(planned[0], harmonic, [len(harmonic)], *given).tolist()
    sizes = ", ".join(f"{size:g} {'N m' if force == 'N' else 'N'} in {force}" for force, size in noise.items())
    notes = (
        f"Assumed: noise of {sizes}, correlated over {correlation_time:g} s; {tank.length_for(configuration):g} m of "
        "steady motion per run.",
        f"Assumed: runs differ by {errors.gain:.1%} in gain, {errors.zero:.1%} of the usual force in zero, and "
        f"{errors.form:.1%} of their force in model form; the form of the bank and a zero that all runs share are "
        "uncertain too.",
        *limits,
    )
    std_of, usual_of = dict(zip(names, std.T, strict=True)), dict(zip(names, usual, strict=True))
    return Plan(chosen, names, std_of, usual_of, len(offered), notes)


def _separating(
    offered: list[Run], adds: np.ndarray, known: np.ndarray, count: int, parameters: list[int]
) -> list[int]:
    """Straight runs at the highest speed, each mirrored: they separate the bank from period-dependent hull forces."""
    steady = {
        (run.offset, run.drift, run.speed, run.depth): i
        for i, run in enumerate(offered) if isinstance(run, StraightRun)
    }  # fmt: skip
    fastest = max((speed for _, _, speed, _ in steady), default=0.0)
    half = [(i, steady[-y, -drift, u, depth]) for (y, drift, u, depth), i in steady.items() if y > 0 and u == fastest]
    best = choose(adds[[i for i, _ in half]], 0 * known, count // 2, parameters)
    return [run for i in best for run in half[i]]


def _forms(terms: TermTable) -> list[TermTable]:
    """The terms, and the same with other forms of the bank: a plan must work under each."""
    if sum(term.from_bank for term in terms.terms) != 2 or terms.needs_depth:
        return [terms]
    return [terms, *(with_bank(terms, form) for form in ("distance", "tapered"))]


def _check(runs: int, terms: TermTable, noise: Mapping[str, float], tank: Tank) -> None:
    if runs < 1:
        raise InputError(f"{runs} runs are no plan; ask for one or more")
    for force, part in terms.forces.items():
        if part and not noise.get(force, 0.0) > 0:
            raise InputError(f"noise: {force} needs a positive standard deviation; give one for each force")
    if tank.depths and not terms.needs_depth:
        raise InputError("no term depends on the water's depth; leave the depths out, or take terms that do")


def _targets(terms: TermTable, targets: Sequence[str]) -> tuple[str, ...]:
    names = (targets,) if isinstance(targets, str) else tuple(targets)
    names = names or tuple(term.name for term in terms.terms if term.from_bank)
    for name in names:
        if name not in terms.names:
            raise InputError(f"the terms have no {name!r}; targets are {', '.join(terms.names)}")
    if not names:
        raise InputError("these terms have no bank to plan for; name the coefficients that matter as targets")
    return names


def expected_model(configuration: Configuration) -> Model:
    """Return a model of the approximate forces: the published one by Froude's law."""
    scaled = scale_model(published("mikkelsen2025_dtc"), configuration.ship.length).model
    return replace(scaled, configuration=configuration)


def within_tested(tank: Tank, tested: DataRange | None) -> tuple[Tank, tuple[str, ...]]:
    """Return a tank limited to the tested speeds and offsets, unless others were set."""
    notes, tested = [], tested or DataRange()
    if tested.speed is not None and not tank.speeds:
        low, high = tested.speed
        # Earlier tests within 5 % count as one speed.
        speeds = (low,) if high - low < 0.05 * high else (low, (low + high) / 2, high)
        tank = replace(tank, speeds=tuple(round(speed, 3) for speed in speeds if round(speed, 3) > 0))
        notes.append(f"Speeds are within those tested, {low:.3g} to {high:.3g} m/s, as none were asked for.")
    if tested.abs_y is not None and tested.abs_y[1] > 0 and tank.reach is None:
        tank = replace(tank, reach=tested.abs_y[1])
        notes.append(f"Offsets are within those tested, {tested.abs_y[1]:.3g} m, as no reach was asked for.")
    return tank, tuple(notes)


# Sampling rate [Hz]; a run's information depends on its noise per time, not on its sampling rate.
RATE = 5.0
# Zero offsets: of harmonic runs, of steady ones to starboard and to port, often made on different days.
ZEROS = 3
# Prior information relative to the largest of each parameter: almost none.
RIDGE = 1e-9
# Relative difference of the sum of variances within which runs count as equal: while a parameter is unknown, rounding
# over the ridge moves it by about 1e-5.
TIE = 1e-4
# Rows of some forces, their mixed model, the coordinates of its scales, and the unit of each scaled coefficient.
Part = tuple[ForceRows, MixedModel, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class ExpectedErrors:
    """Errors that a plan expects of its tests."""

    configuration: Configuration
    noise: Mapping[str, float]  # Standard deviation within a run [N, N, N m]
    correlation_time: float  # of that noise [s]
    runs: RunErrors  # Differences between runs

    def parts(self, equations: NormalEquations, motions: DistinctMotions, terms: TermTable) -> Iterator[Part]:
        """Set up the mixed model of the forces that share coefficients or errors."""
        problem, rows_apart = bounded_problem(equations, terms), max(1.0, 2 * self.correlation_time * RATE)
        blocks = row_blocks(equations, motions)
        for forces in problem.joint_forces:
            noise = rows_apart * np.array([self.noise[force] ** 2 for force in forces])
            rows = ForceRows(equations, motions, blocks, problem, forces, noise)
            model, _, unit = assemble(rows, self.runs, self.configuration)
            # In good tests the median ratio of fitted run-error scales to their priors is 0.7. The hull's discrepancies
            # have their usual sizes, by a global scale of 1: before the tests nobody knows how well the terms fit.
            z = np.full(len(model.prior), np.log(0.7))
            if model.multiples:
                z[-1] = -special.ndtri(2 * special.ndtr(-1 / model.prior[-1]))
            yield rows, model, z, unit

    def information(self, equations: NormalEquations, terms: TermTable) -> np.ndarray:
        """Information of each run, as of ``information_of``."""
        motions = distinct_motions(equations, repeats=False)
        return information_of(self.parts(equations, motions, terms), motions, terms)


def information_of(parts: Iterable[Part], motions: DistinctMotions, terms: TermTable) -> np.ndarray:
    """Information of each motion, (motions, p + zeros, p + zeros), zeros by force and kind of run."""
    # Generalised least squares on the rows of its mean; effects that several motions share are left out.
    forces, size = [force for force, part in terms.forces.items() if part], max(free_parameters(terms).values()) + 1
    zero = np.where(motions.steady, np.where(motions.features["side"] >= 0, 1, 2), 0)
    information = np.zeros((len(motions), *(size + ZEROS * len(forces),) * 2))
    for rows, model, z, _ in parts:
        for (f, force), motion in product(enumerate(rows.forces), range(len(motions))):
            own = np.flatnonzero(rows.of_mean & (rows.motion == motion))
            columns = np.zeros((len(own), information.shape[-1]))
            columns[:, rows.free_parameters] = rows.x[f * rows.each + own]
            columns[:, size + ZEROS * forces.index(force) + zero[motion]] = rows.raw(ONE)[own]
            information[motion] += columns.T @ np.linalg.solve(model.covariance_of(z, f * rows.each + own), columns)
    return information


def known_information(fit: Fit) -> np.ndarray:
    """Information of earlier tests, (p + zeros, p + zeros)."""
    parts = [(part.rows, part.posterior.model, part.posterior.mode, part.unit) for part in fit.estimates.forces]
    return np.asarray(information_of(parts, fit.motions, fit.terms).sum(axis=0))


def choose(runs: np.ndarray, known: np.ndarray, count: int, targets: Sequence[int]) -> list[int]:
    """Choose runs, each at most once, in the order of their use."""
    # runs (n, forms, p, p); known (forms, p, p). Fedorov (1972), Theory of optimal experiments: the exchange.
    scale = np.sqrt(np.diagonal(runs, axis1=2, axis2=3).max(axis=0, initial=0.0))
    scale[scale == 0] = 1.0
    outer = scale[:, :, None] * scale[:, None, :]
    runs, known = runs / outer, known / outer
    base = known + RIDGE * np.eye(known.shape[-1])

    def best(taken: list[int], offered: Sequence[int]) -> int:
        left = np.array([i for i in offered if i not in taken])
        return int(left[_least(base + runs[taken].sum(axis=0) + runs[left], targets)])

    chosen: list[int] = []
    for _ in range(min(count, len(runs))):
        chosen.append(best(chosen, range(len(runs))))
    for _ in range(20):  # Rounds of exchanges, at most
        before = list(chosen)
        for i in range(len(chosen)):
            chosen[i] = best(chosen[:i] + chosen[i + 1 :], range(len(runs)))
        if chosen == before:
            break
    order: list[int] = []
    for _ in chosen:
        order.append(best(order, chosen))
    return order


def _least(information: np.ndarray, targets: Sequence[int]) -> int:
    """The least sum of variances under the worst form; among near-equals the least determinant, then the first."""
    # information (..., forms, p, p)
    covariance = np.linalg.inv(information)[..., np.array(targets)[:, None], np.array(targets)]
    worth = np.trace(covariance, axis1=-2, axis2=-1).max(axis=-1)
    tied = np.flatnonzero(worth <= worth.min() * (1 + TIE))
    volume = np.linalg.slogdet(covariance[tied])[1].max(axis=-1)
    return int(tied[np.flatnonzero(volume <= volume.min() + TIE)[0]])


def expected_errors(
    planned: NormalEquations, runs: Sequence[Run], counts: Sequence[int], targets: Sequence[str], terms: TermTable,
    assumed: ExpectedErrors, made: Fit | None,
) -> np.ndarray:  # fmt: skip
    """Standard errors of some coefficients after the first of the runs and earlier tests, (counts, targets).

    They are infinite where the tests do not determine a coefficient.
    """
    slot, table = free_parameters(terms), []
    for count in counts:
        equations = planned.of_tests([run.name for run in runs[:count]])
        equations = equations if made is None else _joined(made.normal_equations, equations)
        motions, std = distinct_motions(equations), np.zeros(max(slot.values()) + 1)
        for rows, model, z, unit in assumed.parts(equations, motions, terms):
            spread = model.conditional(z).covariance
            std[rows.free_parameters] = np.sqrt(np.diag(spread)[: len(unit)]) * unit
        known = Diagnostics(equations, terms, motions).determined
        table.append([std[slot[name]] if known(name) else np.inf for name in targets])
    return np.array(table)


def _joined(made: NormalEquations, planned: NormalEquations) -> NormalEquations:
    """Sums of the information of earlier and of planned tests."""
    names = set(planned.moved) & set(made.moved)
    return NormalEquations(
        planned.columns,
        np.concatenate([made.unweighted, planned.unweighted]),
        (*made.tests, *(f"planned {name}" for name in planned.tests)),
        {name: np.concatenate([made.moved[name], planned.moved[name]]) for name in names},
        planned.length,
    )
