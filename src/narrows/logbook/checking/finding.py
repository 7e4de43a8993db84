"""Faults of a record: the evidence in numbers, and the remedy."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.logbook.checking.agreement import EvenMotion
from narrows.logbook.ship_record import ShipRecord
from narrows.model.model import Model
from narrows.results import BaseResult
from narrows.waterway import Waterway

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
        return ("where nothing is found, nothing contradicts: a quiet record hardly tells the rudder's sign",)

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


# A record as the checks take it: with the ship that it is of, and its motion at even times.
class Examined(NamedTuple):
    record: ShipRecord  # As it was measured
    motion: EvenMotion  # The same at even times
    model: Model  # Model of the ship
    waterway: Waterway | None  # That x and y are told along

    @property
    def length(self) -> float:
        return self.model.configuration.ship.length

    @property
    def speed(self) -> float:
        return self.length / self.motion.pace

    def finding(
        self, check: str, sentence: str, remedy: str, evidence: Mapping[str, float], wrong: bool = True
    ) -> Finding:
        return Finding(
            check, self.record.name, sentence, remedy, {name: float(n) for name, n in evidence.items()}, wrong
        )

    @property
    def turning(self) -> np.ndarray | None:
        """Yaw rate at even times [rad/s], by the sensor or else by the heading; None where there is neither."""
        if "r" in self.motion:
            return self.motion["r"]
        return np.gradient(self.motion.heading, self.motion.dt) if "psi" in self.motion else None


# The checks by stage: what a later one rests on must be right by the earlier ones.
class LogStage(IntEnum):
    """Stage at which a check runs."""

    SENSORS = 0  # Rests on nothing else
    HEADING = 1  # On sensors that are well
    MOTION = 2  # On a heading that is right
    PLACE = 3  # The same, and reports after the checks of the motion
    MODEL = 4  # Only where nothing is wrong so far


Check = Callable[[Examined], Iterator[Finding]]


class LogCheck(NamedTuple):
    """A check of single records."""

    check: Check
    stage: LogStage
    example: Callable[[ShipRecord], ShipRecord] | None  # Spoils a good record of a zigzag by what the check finds


CHECKS: list[LogCheck] = []


def log_check(stage: LogStage, example: Callable[[ShipRecord], ShipRecord] | None = None) -> Callable[[Check], Check]:
    """Add a function to the checks; in a module of this folder whose name ends in ``_checks`` it is found."""

    def added(check: Check) -> Check:
        CHECKS.append(LogCheck(check, stage, example))
        return check

    return added
