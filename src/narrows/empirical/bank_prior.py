"""Bank coefficients of an untested ship: their distribution over tested ships and depths.

Each row is a model of the paper's form (delta) of one ship at one depth. The distribution is normal, with mean and
standard deviation of the rows; that of a further ship is wider by the error of the mean. Norrbin's (1974) formula is
not used because its distance is printed with several meanings, nor are Ch'ng et al. (1993) and Vantorre et al. (2003),
because no two sources agree on their coefficients.
"""

import math
from typing import NamedTuple

import numpy as np

from narrows.empirical.calibration import Spread


class BankEvidence(NamedTuple):
    ship: str
    source: str
    depth_to_draft: float | None
    width_to_beam: float
    suction: float  # b_bank
    cushion: float  # c_bank


_KCS = "harmonic tests, Flanders Hydraulics, with the terms crossflow"
_LATAIRE = "steady tests along banks, Lataire et al. (2009), without drift"

BANK_EVIDENCE = (
    BankEvidence("DTC", "Mikkelsen et al. (2025)", None, 12.2, 1.07, 0.13),
    BankEvidence("KCS", _KCS, 2.0, 11.4, -0.015, 0.055),
    BankEvidence("KCS", _KCS, 1.5, 11.4, -0.086, 0.077),
    BankEvidence("KCS", _KCS, 1.2, 11.4, -0.164, 0.214),
    BankEvidence("8000 TEU ship", f"{_LATAIRE}, propeller on", None, 13.2, 0.107, 0.048),
    BankEvidence("8000 TEU ship", f"{_LATAIRE}, propeller off", None, 13.2, -0.001, 0.018),
)


def bank_prior() -> dict[str, Spread]:
    """Return suction and cushion of a ship without bank tests, ``Y_bank`` and ``N_bank``."""
    widened = math.sqrt(1 + 1 / len(BANK_EVIDENCE))
    columns = {
        "Y_bank": [row.suction for row in BANK_EVIDENCE],
        "N_bank": [row.cushion for row in BANK_EVIDENCE],
    }
    return {
        name: Spread(float(np.mean(values)), widened * float(np.std(values, ddof=1)))
        for name, values in columns.items()
    }


def tested_widths() -> tuple[float, float]:
    """Return the smallest and the largest W/B of the evidence [1]."""
    widths = [row.width_to_beam for row in BANK_EVIDENCE]
    return min(widths), max(widths)
