"""How well a fit to planned runs will know the coefficients: the mixed model of ``identify`` on runs without noise."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from narrows.captive.synthetic import Run, twin
from narrows.identification.estimates import HALF
from narrows.identification.fit import Fit
from narrows.identification.force_rows import ForceRows
from narrows.identification.motions import distinct_motions
from narrows.identification.regression.accumulation import accumulate
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.identification.regression.problem import reduced
from narrows.identification.run_blocks import run_blocks
from narrows.identification.run_errors import RunErrors
from narrows.identification.systematic_effects import assemble
from narrows.model.model import Model
from narrows.terms.term import TermTable

# Of sampling [Hz]; what a run tells depends on its noise per time, not on how often it is sampled.
RATE = 5.0
# Scales over their priors' that a fit to well-made tests finds, at the median.
TYPICAL = 0.7


def expected_std(
    runs: Sequence[Run], truth: Model, terms: TermTable, noise: Mapping[str, float], correlation_time: float,
    errors: RunErrors, made: Fit | None = None,
) -> dict[str, float]:  # fmt: skip
    """Standard error of each coefficient after some runs, and after those that were made before."""
    tests = twin(truth, tuple(runs), {}, rate=RATE)
    equations, _ = accumulate(tests, terms)
    if made is not None:
        equations = _joined(made.normal_equations, equations)
    motions, problem = distinct_motions(equations), reduced(equations, terms)
    forces = tuple(force for force, part in terms.forces.items() if part)
    std: dict[str, float] = {}
    for group in [("X",), ("Y", "N")] if not _tied(terms) else [forces]:
        own = tuple(force for force in group if force in forces)
        if not own:
            continue
        blocks = run_blocks(equations, motions, own)
        within = np.array([noise[f] ** 2 * max(1.0, 2 * correlation_time * RATE) for f in own])
        rows = ForceRows(replace(blocks, noise=within), motions, problem, equations.columns)
        model, _, unit = assemble(rows, errors, truth.configuration)
        spread = model.at(np.where(model.prior > 0, np.log(TYPICAL), 0.0)).covariance
        size = np.sqrt(np.diag(spread)[: len(unit)]) * unit
        std |= {term.name: float(size[rows.slots.index(problem.slot[term.name])]) for _, term in rows.terms}
    return std


def half_width(std: float) -> float:
    """Half of the 95 % interval that a standard error makes."""
    return HALF * std


def _tied(terms: TermTable) -> bool:
    """Whether surge shares a coefficient with sway or yaw."""
    surge = {term.name for term in terms.surge}
    return any(len(surge & set(tie)) == 1 for tie in terms.ties)


def _joined(made: NormalEquations, planned: NormalEquations) -> NormalEquations:
    """Sums of tests that were made and of planned ones."""
    names = set(planned.moved) & set(made.moved)
    return NormalEquations(
        planned.columns,
        np.concatenate([made.unweighted, planned.sums]),
        (*made.tests, *(f"planned {name}" for name in planned.tests)),
        {name: np.concatenate([made.moved[name], planned.moved[name]]) for name in names},
        planned.length,
    )
