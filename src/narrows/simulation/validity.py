"""Where a voyage leaves what the model's data covered."""

import numpy as np

from narrows.model.data_range import MEASURES, DataRange


def beyond_envelope(known: DataRange, columns: dict[str, np.ndarray]) -> tuple[str, ...]:
    """Say in what a voyage went beyond the data of its model."""
    seen = {
        "speed": columns["u"],
        "abs_y": np.abs(columns["y"]),
        "abs_psi": np.abs(columns["psi"]),
        "abs_r": np.abs(columns["r"]),
    }
    sentences = [_sentence(name, known, seen[name], columns["t"]) for name in seen]
    return tuple(sentence for sentence in sentences if sentence)


def _sentence(name: str, known: DataRange, values: np.ndarray, t: np.ndarray) -> str:
    outside = known.outside(name, values)
    if not outside.any():
        return ""
    measure, first = MEASURES[name], int(np.argmax(outside))
    there, covered = measure.shown(values[first], values[first]), measure.shown(*getattr(known, name))
    return f"From {t[first]:.2f} s its {measure.words} of {there} is outside the data ({covered})."
