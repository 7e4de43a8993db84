"""Where the priors of the mixed model come from: how well other sizes predict left-out KCS tests, a table of the docs.

    python decisions/trust_priors.py [--write]

The log predictive density of left-out motions and of left-out speeds, summed over three clearances and two tables of
terms, less that of the defaults. Importance sampling repeats it to about 8.
"""

from collections.abc import Sequence

import numpy as np
from pages import Rows, markdown, publish, records

import narrows as nw
from narrows.identification import systematic_effects as effects
from narrows.identification.estimates import ForcePosterior, without_rows

HEADER = ("prior", "left-out motions", "left-out speeds")
GROUPS = {
    "inertia by speed": ("inertia by speed",),
    "inertia by period": ("inertia by period",),
    "damping by speed": ("damping by speed",),
    "damping by period": ("damping by period",),
    "other hull terms, walls": ("other hull terms", "walls"),
    "form of the bank": ("bank form",),
    "force, heading, rudder, crossflow with y": ("force with y", "heading with y", "rudder with y", "crossflow with y"),
    "heading, rail, common zero, side force": ("heading", "rail", "common zero", "side force"),
    "clock": ("clock",),
    "settling": ("settling",),
    "crosstalk": ("crosstalk",),
    "curvature, mount": ("curvature", "mount"),
}
HALF_NORMAL = 10.0  # degrees of freedom
DRAWS = 8


def density(part: ForcePosterior, groups: Sequence[Sequence[int]]) -> float:
    """Log predictive density of groups of motions, each by the others."""
    rows, posterior = part.rows, part.posterior
    best = np.argsort(-posterior.weights, kind="stable")[:DRAWS]
    weights = posterior.weights[best] / posterior.weights[best].sum()
    of_motion = rows.all(rows.motion)
    is_mean = rows.all(rows.of_mean)
    total = 0.0
    for group in groups:
        own = np.flatnonzero(np.isin(of_motion, group))
        seen = np.flatnonzero(np.isin(of_motion, group) & is_mean)
        logs, chosen = [], np.searchsorted(own, seen)
        for mean, covariance in zip(*without_rows(part, best, own)[:2], strict=True):
            error, spread = rows.y[seen] - mean[chosen], covariance[np.ix_(chosen, chosen)]
            logs.append(-0.5 * (np.linalg.slogdet(2 * np.pi * spread)[1] + error @ np.linalg.solve(spread, error)))
        total += float(np.logaddexp.reduce(np.log(weights) + logs))
    return total


def densities() -> np.ndarray:
    """Of left-out motions and of left-out speeds."""
    total = np.zeros(2)
    for tests in nw.measured_tests("kcs").by_condition().values():
        for terms in ("paper", "crossflow"):
            fit = nw.identify(tests, terms)
            part = next(part for part in fit.estimates.forces if "N" in part.rows.forces)
            level = np.round(np.log(fit.motions.features["speed"]) / 0.08)
            speeds = [np.flatnonzero(level == one).tolist() for one in np.unique(level)]
            total += [density(part, [[i] for i in range(len(fit.motions))]), density(part, speeds)]
    return total


def text() -> str:
    """Each group of sizes four times as large, and added masses with a prior that is almost normal."""
    usual = densities()
    rows = []
    for name, sizes in GROUPS.items():
        kept = {size: effects.SIZES[size] for size in sizes}
        effects.SIZES.update({size: 4 * value for size, value in kept.items()})
        rows.append((f"{name} x 4", *(f"{gain:+.0f}" for gain in densities() - usual)))
        effects.SIZES.update(kept)
    inertia = [f"{effects.INERTIA} by {trend}" for trend in ("speed", "period")]
    effects.FREEDOM.update(dict.fromkeys(inertia, HALF_NORMAL))
    rows.append(("inertia by speed and period, half-normal", *(f"{gain:+.0f}" for gain in densities() - usual)))
    for name in inertia:
        del effects.FREEDOM[name]
    return markdown(HEADER, rows)


def shown(rows: Rows) -> str:
    """The range of the gains by larger sizes, and those by the last prior."""
    *sizes, last = records(rows, "prior")
    gains = [float(row[name]) for row in sizes for name in HEADER[1:]]
    return (
        f"Quadrupling any of {len(sizes)} groups of sizes changes the density by {min(gains):.0f} to "
        f"{max(gains):+.0f}; a half-normal prior of the added masses by {last[HEADER[1]]} and {last[HEADER[2]]}."
    )


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text(), shown)
