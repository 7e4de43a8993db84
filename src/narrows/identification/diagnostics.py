"""Collinearity diagnostics of every force: over all rows, within each test, at each speed."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.identification.diagnosis import Diagnosis, diagnose
from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.terms.term import TermTable


@dataclass(frozen=True)
class Diagnostics:
    """The columns of every force, whatever the forces are; each diagnosis is made when it is first asked for."""

    equations: NormalEquations  # The sums
    terms: TermTable  # The terms
    motions: DistinctMotions  # The distinct motions, and their speeds

    @cached_property
    def overall(self) -> dict[str, Diagnosis]:
        """Over all rows: force -> diagnosis."""
        return self.over(self.equations.total)

    @cached_property
    def by_test(self) -> dict[str, dict[str, Diagnosis]]:
        """Within each test by itself: test -> force -> diagnosis."""
        return {name: self.over(self.equations.of_test(name)) for name in self.equations.names}

    @cached_property
    def by_speed(self) -> dict[float, dict[str, Diagnosis]]:
        """Over the tests of each speed together: mean speed [m/s] -> force -> diagnosis."""
        motions = self.motions
        return {
            float(np.mean(motions.features["speed"][members])): self.over(motions.sums[members].sum(axis=0))
            for members in motions.by_speed
        }

    def over(self, sums: np.ndarray) -> dict[str, Diagnosis]:
        """Diagnose each force that has terms over the rows behind some sums."""
        # sums (m, m)
        return {force: diagnose(self.equations, sums, part) for force, part in self.terms.forces.items() if part}

    def determined(self, name: str, among: Mapping[str, Diagnosis] | None = None) -> bool:
        """Return whether rows determine a coefficient, through its own force or through one that it is tied to."""
        tied = {name, *(other for tie in self.terms.ties if name in tie for other in tie)}
        diagnoses = (self.overall if among is None else among).values()
        return any(np.isfinite(d.vif[other]) for d in diagnoses for other in tied if other in d.names)
