"""All that is wrong with a log, as a result."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from narrows.logbook.checking.finding import Finding
from narrows.results import Shown

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class LogFindings(Shown):
    """What is wrong with a log, and what is doubtful.

    Parameters
    ----------
    findings : tuple of Finding
        In the order of the records.
    records : int
        How many were looked at.
    """

    findings: tuple[Finding, ...]
    records: int

    def __len__(self) -> int:
        """How many findings."""
        return len(self.findings)

    def __iter__(self) -> Iterator[Finding]:
        """The findings."""
        return iter(self.findings)

    @property
    def clean(self) -> bool:
        """Whether nothing must be mended before a fit."""
        return not any(finding.wrong for finding in self.findings)

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """What must be mended before a fit."""
        return tuple(finding for finding in self.findings if finding.wrong)

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is to be looked at, and need not be mended: a sentence for each kind."""
        return tuple(self._lines([finding for finding in self.findings if not finding.wrong]))

    @staticmethod
    def _lines(findings: Sequence[Finding]) -> list[str]:
        """One for all records in which the same is found, with the numbers of the first."""
        alike: dict[tuple[str, str], list[Finding]] = {}
        for own in findings:
            alike.setdefault((own.check, own.remedy), []).append(own)
        lines = []
        for (check, remedy), (first, *others) in alike.items():
            more, grade = f" and {len(others)} more" if others else "", "" if first.wrong else " (doubtful)"
            lines.append(f"{check}{grade}: in {first.record}{more}, {first.sentence}; {remedy}.")
        return lines

    @property
    def notes(self) -> tuple[str, ...]:
        """That silence is no proof."""
        return ("where nothing is found, nothing contradicts: a quiet record hardly tells the rudder's sign",)

    def summary(self) -> str:
        """Say what is wrong, once for all records in which it is, with the numbers of the first."""
        looked = f"{self.records} record{'s' * (self.records > 1)} looked at"
        if not self.findings:
            return f"Nothing is wrong: {looked}."
        lines = self._lines(self.findings)
        return "\n".join([f"{len(lines)} finding{'s' * (len(lines) > 1)}, {looked}.", *lines])

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name."""
        return {
            "records": self.records, "clean": self.clean, "findings": [own.to_dict() for own in self.findings],
            "summary": self.summary(), "notes": list(self.notes),
        }  # fmt: skip

    def to_dataframe(self) -> "pd.DataFrame":
        """Give a row for each finding: record, check, whether it is wrong, sentence, remedy."""
        import pandas as pd

        rows = [(own.record, own.check, own.wrong, own.sentence, own.remedy) for own in self.findings]
        return pd.DataFrame(rows, columns=["record", "check", "wrong", "sentence", "remedy"])
