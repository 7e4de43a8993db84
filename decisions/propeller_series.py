"""Thrust of a propeller that turns astern: the fits of ``narrows.empirical.formulas``, from a published series.

``propeller_series.csv`` has 100 times the Fourier coefficients of C_T* over the advance angle, of the Wageningen B4-70
propellers at the pitch ratios 0.6 to 1.2, from appendix B of Roddy, Hess and Faller (2006), NSWCCD-50-TR-2006/004. They
were taken from a transcription; at the pitch ratio 1.4 a second one has the same numbers.

python decisions/propeller_series.py
"""

from pathlib import Path

import numpy as np
import pandas as pd
from pages import markdown

TABLE = pd.read_csv(Path(__file__).with_suffix(".csv"), index_col="k")
ADVANCE = -np.linspace(0.0, 1.5, 31)
FORMS = np.stack([np.ones_like(ADVANCE), ADVANCE, np.sqrt(ADVANCE**2 + 0.49)], axis=1)


def thrust(advance: np.ndarray, pitch: str, sign: int) -> np.ndarray:
    """K_T at advances, of revolutions ahead (sign 1) or astern (-1)."""
    angle = np.multiply.outer(TABLE.index, np.arctan2(sign * advance, 0.7 * np.pi * sign))
    waves = TABLE[f"A_{pitch}"].to_numpy() @ np.cos(angle) + TABLE[f"B_{pitch}"].to_numpy() @ np.sin(angle)
    return np.asarray(np.pi / 8 * (advance**2 + (0.7 * np.pi) ** 2) * waves / 100)


def fits() -> str:
    rows = []
    for pitch in (name.removeprefix("A_") for name in TABLE.columns if name.startswith("A_")):
        series = thrust(ADVANCE, pitch, -1)
        found = np.linalg.lstsq(FORMS, series, rcond=None)[0]
        off = np.abs(FORMS @ found - series).max()
        rows.append((pitch, f"{thrust(np.zeros(1), pitch, 1)[0]:.4f}", *(f"{a:.3f}" for a in found), f"{off:.3f}"))
    return markdown(("pitch ratio", "K_T ahead at J = 0", "a_0", "a_1", "a_2", "largest error of K_T"), rows)


if __name__ == "__main__":
    print(fits())
    print("\nJ^2 in the same functions:", np.linalg.lstsq(FORMS, ADVANCE**2, rcond=None)[0].round(3))
