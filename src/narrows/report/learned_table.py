"""Coefficients before a record and after it, as a table has them."""

from collections.abc import Mapping

from narrows.logbook.learned_coefficient import PRIOR, LearnedCoefficient
from narrows.report.numbers import readable

LEARNED_HEADS = ("", "before", "after", "95 % interval", "unit")
# From here a number is written with a power of ten.
LONG = 1e5


def learned_rows(coefficients: Mapping[str, LearnedCoefficient]) -> list[tuple[str, ...]]:
    """Return what a table says of each coefficient that a record taught something of, the surest first."""
    learned = sorted((c for c in coefficients.values() if c.word != PRIOR), key=lambda c: c.left)
    return [
        (c.name, f"{_short(c.prior, c.prior_std)} ± {_short(c.prior_std, c.prior_std)}",
         f"{_short(c.value, c.std)} ± {_short(c.std, c.std)}",
         " to ".join(_short(end, c.std) for end in c.interval), c.unit, c.verdict)
        for c in learned
    ]  # fmt: skip


def with_truth(rows: list[tuple[str, ...]], truth: Mapping[str, float] | None) -> list[tuple[str, ...]]:
    """Return rows with the truth of a twin as their last cell."""
    return rows if truth is None else [(*row, f"{truth[row[0]]:.3g}") for row in rows]


def _short(value: float, std: float) -> str:
    """Metric tons and more in powers of ten."""
    return f"{value:.3g}" if abs(value) >= LONG else readable(value, std)
