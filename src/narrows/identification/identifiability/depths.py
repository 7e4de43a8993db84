"""Whether a coefficient of the bank is the same at every depth, from what the tests at each depth tell of it alone."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from narrows.identification.identifiability.other_estimates import ComparedEstimate

# Probability of as much difference under which a coefficient is said to change with the depth.
DIFFERENT = 0.05


@dataclass(frozen=True)
class DepthTest:
    """A coefficient at each depth by itself, and the test of whether it is one."""

    values: Mapping[float, float]  # Its estimate by the tests at each depth alone, in its unit [m]
    std: Mapping[float, float]  # Their standard errors [m]
    chi2: float  # Sum of squared distances from their weighted mean, each over its standard error [1]
    p: float  # Probability of as much, were it one coefficient [1]

    @property
    def changes(self) -> bool:
        """Whether it differs between depths by more than its errors allow."""
        return self.p < DIFFERENT

    def sentence(self, name: str) -> str:
        """Say it."""
        told = ", ".join(f"{value:.3g} +- {self.std[h]:.2g} at {h:.4g} m" for h, value in self.values.items())
        word = "it changes with the depth" if self.changes else "no change with the depth is seen"
        return f"{name} by each depth alone is {told}: {word} (p = {self.p:.2g})."


def depth_test(compared: Iterable[ComparedEstimate], std_over_reach: float) -> DepthTest | None:
    """Compare what the tests at each depth tell of a coefficient; None where fewer than two depths do."""
    from scipy.special import chdtrc

    known = [(*c.stratum, c) for c in compared if c.stratum and not c.lost]
    by_depth = {depth: c for stratum, depth, c in known if stratum == "depth"}
    if len(by_depth) < 2:
        return None
    depths = sorted(by_depth)
    values = np.array([by_depth[h].value for h in depths])
    std = np.array([by_depth[h].reach for h in depths]) * std_over_reach
    mean = (values / std**2).sum() / (1 / std**2).sum()
    chi2 = float((((values - mean) / std) ** 2).sum())
    told, errors = (dict(zip(depths, part.tolist(), strict=True)) for part in (values, std))
    return DepthTest(told, errors, chi2, float(chdtrc(len(depths) - 1, chi2)))
