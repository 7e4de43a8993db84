"""What answers of records have alike: what each coefficient was taught."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from narrows.logbook.learned_coefficient import LearnedCoefficient, coefficient_frame
from narrows.results import Shown

if TYPE_CHECKING:
    import pandas as pd


class LearnedAnswer(Shown):
    """What was taught of each coefficient, by name."""

    coefficients: Mapping[str, LearnedCoefficient]

    @property
    def std(self) -> dict[str, float]:
        """Standard error of each coefficient."""
        return {name: coefficient.std for name, coefficient in self.coefficients.items()}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each coefficient."""
        return {name: coefficient.interval for name, coefficient in self.coefficients.items()}

    @property
    def verdicts(self) -> dict[str, str]:
        """What was learned of each coefficient, in a word or two."""
        return {name: coefficient.verdict for name, coefficient in self.coefficients.items()}

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the coefficients as a table: a row each, before and after."""
        return coefficient_frame(self.coefficients)
