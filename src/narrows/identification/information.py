"""Candidate runs, their Fisher information, the best choice of them, and the errors expected after it."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import special

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.captive.synthetic import HarmonicRun, Run, StraightRun
from narrows.identification.fit import Fit
from narrows.identification.least_squares import bounded_problem, free_parameters
from narrows.identification.mixed_model import MixedModel
from narrows.identification.motions import DistinctMotions, ForceRows, distinct_motions
from narrows.identification.normal_equations import ONE, NormalEquations
from narrows.identification.systematic_effects import RunErrors, assemble
from narrows.identification.verdict import Diagnostics
from narrows.model.term import TermTable
from narrows.ship.particulars import Configuration, Ship, half_swept

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
        for forces in problem.joint_forces:
            noise = rows_apart * np.array([self.noise[force] ** 2 for force in forces])
            rows = ForceRows(equations, motions, problem, forces, noise)
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


# Offsets and amplitudes as shares of the distance between hull and wall.
OFFSETS, AMPLITUDES = (0.0, 0.35, 0.7), (0.3, 0.6, 1.0)
# Starboard and port: each run off the centreline may be mirrored.
SIDES = (1, -1)
# Steady motion of a run over the ship's length; and a limit above any tank's data, in SI.
RUN_LENGTHS, MOST = 10.0, 1e5
# Largest speed over the root of g L of a ship in a canal; largest number of samples in a run.
MOST_FROUDE, MOST_SAMPLES = 0.4, 100_000


@accept_aliases
@dataclass(frozen=True)
class Tank:
    """Limits of a towing tank.

    Raises an InputError if a number is not positive.

    >>> nw.Tank(speeds=(0.6, 0.8)).speeds
    (0.6, 0.8)
    """

    run_length: float | None = None  #: Steady motion in one run [m]; ten ship lengths unless given
    #: Least distance from the hull's side to a wall [1], over the beam: closer to it, every form of the bank term is
    #: uncertain
    clearance: float = 1.5
    heading: float = 25.0  #: Largest heading in a yaw test [deg], and drift angle in a sway test
    speeds: Sequence[float] = ()  #: Speeds of runs [m/s]; three slow ones by the ship's length unless given
    depths: Sequence[float] = ()  #: Depths of runs [m]; the canal's own unless given
    #: Largest offset of midship from the centreline [m]; default: three quarters of the limit by the clearance, since
    #: every form of the bank errs most close to a wall
    reach: float | None = None

    def __post_init__(self) -> None:
        for name, values in vars(self).items():
            for value in () if values is None else np.ravel(values):
                if not 0 < value < MOST:
                    raise InputError(f"tank: {name} = {value} must be positive, and of a tank's size")

    def length_for(self, configuration: Configuration) -> float:
        """Return the length of steady motion in a run [m], for the ship of a ``configuration``."""
        return RUN_LENGTHS * configuration.ship.length if self.run_length is None else self.run_length


def candidates(configuration: Configuration, tank: Tank) -> list[Run]:
    """List the runs that fit between the walls and into the length of a tank."""
    ship, length = configuration.ship, tank.length_for(configuration)
    clear = configuration.canal.width / 2 - ship.beam * (0.5 + tank.clearance)
    room = 0.75 * clear if tank.reach is None else min(clear, tank.reach)
    if room <= 0:
        raise InputError("no run fits between the walls of this tank; check the ship file, or ask for less clearance")
    dry = [depth for depth in tank.depths if depth <= ship.draft]
    if dry:
        raise InputError(f"a depth of {dry[0]} m leaves no water under a draft of {ship.draft} m; raise it")
    wave = (9.81 * ship.length) ** 0.5
    for speed in tank.speeds:
        if speed > MOST_FROUDE * wave or length / speed > MOST_SAMPLES:
            raise InputError(f"{speed:g} m/s is no speed for a ship {ship.length:g} m long in a tank; check it")
    runs = []
    slow = [round(froude * wave, 3) for froude in (0.08, 0.12, 0.16)]  # As in canals
    for speed, depth in product(tank.speeds or slow, tank.depths or (None,)):
        runs += [*_straight(room, length, speed, depth), *_harmonic(room, length, tank.heading, speed, depth)]
    limit = configuration.canal.width / 2 - tank.clearance * ship.beam + 1e-9
    return [run for run in runs if _reach(run, ship) <= limit]


def _straight(room: float, length: float, speed: float, depth: float | None) -> Iterator[Run]:
    for share, side, drift in product((0.0, 0.25, 0.5, 0.75, 1.0), SIDES, (0.0, 6.0)):
        offset, drift = side * round(share * room, 3), side * drift + 0.0  # Never -0
        if (share or drift) and (share or side > 0):
            name = f"straight y={offset:g} drift={drift:g} u={speed:g}{_at(depth)}"
            yield StraightRun(name, offset, speed, length / speed, float(np.radians(drift)), depth)


def _harmonic(room: float, length: float, heading: float, speed: float, depth: float | None) -> Iterator[Run]:
    for kind, offset_share, side, share, cycles in product(("yaw", "sway"), OFFSETS, SIDES, AMPLITUDES, (2, 3, 5)):
        offset = side * round(offset_share * room, 3)
        amplitude, period = round(share * (room - abs(offset)), 3), round(length / speed / cycles, 2)
        # Path angle at the centre crossing: a yaw run moves along its heading (sine), a sway run drifts (tangent).
        steepest = speed * (np.sin if kind == "yaw" else np.tan)(np.radians(heading))
        if (offset or side > 0) and 0 < amplitude * 2 * np.pi / period < steepest:
            name = f"{kind} A={amplitude:g} y={offset:g} T={period:g} u={speed:g}{_at(depth)}"
            yield HarmonicRun(name, kind, amplitude, period, speed, cycles, offset, depth)


def _at(depth: float | None) -> str:
    return "" if depth is None else f" h={depth:g}"


def _reach(run: Run, ship: Ship) -> float:
    columns = run.columns(100 / run.duration)
    return float((np.abs(columns["y"]) + half_swept(ship, columns["psi"])).max())
