"""What is wrong with a record: what was seen, in numbers, and what to do."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Finding:
    """Something that is wrong, or doubtful, with a record.

    Parameters
    ----------
    check : str
        What was looked at, as in ``rudder's sign``.
    record : str
        Of which record.
    sentence : str
        What was seen, with its numbers.
    remedy : str
        What to do.
    evidence : mapping of str to float
        The numbers.
    wrong : bool
        Whether it must be mended before a fit; else it is to be looked at.
    """

    check: str
    record: str
    sentence: str
    remedy: str
    evidence: Mapping[str, float] = field(default_factory=dict)
    wrong: bool = True

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name."""
        return {
            "check": self.check, "record": self.record, "sentence": self.sentence, "remedy": self.remedy,
            "evidence": dict(self.evidence), "wrong": self.wrong,
        }  # fmt: skip
