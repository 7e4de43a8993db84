"""Faults of a record: the evidence in numbers, and the remedy."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from narrows.results import BaseResult

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Finding:
    """Something that is wrong, or doubtful, with a record."""

    check: str  # What was looked at, as in ``rudder's sign``
    record: str
    sentence: str  # What was seen, with its numbers
    remedy: str
    evidence: Mapping[str, float] = field(default_factory=dict)
    wrong: bool = True  # Whether it must be mended before a fit; else it is to be looked at

    def to_dict(self) -> dict[str, Any]:
        return {
            "check": self.check, "record": self.record, "sentence": self.sentence, "remedy": self.remedy,
            "evidence": dict(self.evidence), "wrong": self.wrong,
        }  # fmt: skip


# All that is wrong with a log, as a result.
@dataclass(frozen=True, repr=False)
class LogFindings(BaseResult):
    """Faults and doubts of a log.

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
        return len(self.findings)

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.findings)

    @property
    def clean(self) -> bool:
        """True where nothing must be mended before a fit."""
        return not any(finding.wrong for finding in self.findings)

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """Faults that must be mended before a fit."""
        return tuple(finding for finding in self.findings if finding.wrong)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Doubts, which need not be mended: a sentence for each kind."""
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
        """Note that a clean check is no proof."""
        return ("no finding is no proof: a quiet record has little information on the sign of its rudder",)

    def summary(self) -> str:
        """Each fault once for all records that have it, with the numbers of the first."""
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
