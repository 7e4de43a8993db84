"""Scores of recorded transits: contacts that were missed, how early the others were told, and what was told in vain."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.results import Described
from narrows.warning.scoring.scored_transit import PREDICTORS, ScoredTransit
from narrows.warning.scoring.standing_alerts import NEEDED, lead_times, standing_since

if TYPE_CHECKING:
    import pandas as pd

# Clearance [m] below which a transit counts as a contact, for an estimate is no surer; and above which it is quiet.
LIMIT, QUIET = 5.0, 20.0


@dataclass(frozen=True)
class PredictorScore:
    """Of one predictor."""

    predictor: str  # With its threshold, or a level of the monitor
    missed: int  # Contacts before which it did not stand for 20 s
    lead: float  # Median time that it stood before a contact; NaN without one [s]
    false: int  # Quiet transits in which it was raised
    near: int  # Transits that came near, without contact, in which it was raised


@dataclass(frozen=True, repr=False)
class TransitScores(Described):
    """How well warnings did in recorded transits."""

    contacts: int  # Transits by what became of them
    quiet: int  # Transits by what became of them
    near: int  # Transits by what became of them
    limit: float  # Clearance that counts as contact [m]
    rows: tuple[PredictorScore, ...]  # A predictor each
    leads: dict[str, tuple[float, ...]]  # By transit with a contact: how long each predictor stood before it [s]
    unknown: tuple[str, ...]  # Transits of which nothing could be foretold

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of them."""
        rule = (
            f"A contact is a clearance below {self.limit:g} m as the estimate has it; quiet is what always had more "
            f"than {QUIET:g} m; missed is what stood less than {NEEDED:g} s before a contact."
        )
        few = ("So few transits tell little: see the intervals in docs/warning.md.",)
        left = tuple(f"Nothing could be foretold of {name}: it is left out." for name in self.unknown)
        return (rule, *few, *left)

    def summary(self) -> str:
        """Say what became of the transits, and of each predictor what it missed and told in vain."""
        met = f"{self.contacts} {'transit' if self.contacts == 1 else 'transits'} with a contact"
        lines = [f"{met}, {self.near} that came near, {self.quiet} quiet ones."]
        for row in self.rows:
            lead = f", {row.lead:.0f} s before it (median)" if math.isfinite(row.lead) else ""
            vain = f"in vain in {row.false} of {self.quiet}"
            lines.append(f"{row.predictor}: missed {row.missed} of {self.contacts}{lead}; {vain}.")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Give them by name: what ``monitor --score --json`` prints."""
        counts = {"contacts": self.contacts, "near": self.near, "quiet": self.quiet, "limit": self.limit}
        leads = {name: dict(zip(PREDICTORS, row, strict=True)) for name, row in self.leads.items()}
        rows = [vars(row) for row in self.rows]
        return {"summary": self.summary(), **counts, "predictors": rows, "leads": leads, "notes": [*self.notes]}

    def to_dataframe(self) -> "pd.DataFrame":
        """Give a row a predictor."""
        import pandas as pd

        return pd.DataFrame([vars(row) for row in self.rows]).set_index("predictor")


def score_transits(transits: Sequence[ScoredTransit], limit: float = LIMIT) -> TransitScores:
    """Return the scores of transits."""
    # limit [m]
    if not 0.0 <= limit < QUIET:
        raise InputError(f"a clearance of {limit:g} m cannot tell contacts from quiet transits; give 0 to {QUIET:g} m")
    known = [one for one in transits if np.isfinite(one.urgencies).any()]
    unknown = tuple(one.name for one in transits if not np.isfinite(one.urgencies).any())
    met = [one for one in known if math.isfinite(one.struck(limit))]
    quiet = [one for one in known if one.least > QUIET]
    near = [one for one in known if one not in met and one not in quiet]
    leads = {one.name: _leads(one, one.struck(limit)) for one in met}
    told, vain, close = (np.array([*rows]).reshape(-1, len(PREDICTORS)) for rows in (
        leads.values(), map(_raised, quiet), map(_raised, near)
    ))  # fmt: skip
    rows = tuple(
        PredictorScore(
            name, int((told[:, k] < NEEDED).sum()), float(np.median(told[:, k])) if len(met) else math.nan,
            int(vain[:, k].sum()), int(close[:, k].sum()),
        )
        for k, name in enumerate(PREDICTORS)
    )  # fmt: skip
    return TransitScores(len(met), len(quiet), len(near), limit, rows, leads, unknown)


def _leads(one: ScoredTransit, struck: float) -> tuple[float, ...]:
    since = standing_since(one.t, one.urgencies)
    return tuple(lead_times(one.t, since, np.full(len(PREDICTORS), struck)).tolist())


def _raised(one: ScoredTransit) -> np.ndarray:
    return np.asarray(np.isfinite(standing_since(one.t, one.urgencies)).any(axis=0))
