"""Where a voyage leaves what the model's data covered."""

import numpy as np

from narrows.model.data_range import DataRange, Range

WORDS = {
    "speed": ("surge velocity", "m/s", 1.0),
    "abs_y": ("offset from the centreline", "m", 1.0),
    "abs_psi": ("heading", "deg", 180 / np.pi),
    "abs_r": ("yaw rate", "deg/s", 180 / np.pi),
}


def beyond_envelope(known: DataRange, columns: dict[str, np.ndarray]) -> tuple[str, ...]:
    """Say in what a voyage went beyond the data of its model (ours).

    Parameters
    ----------
    known : DataRange
        Of the model.
    columns : dict of str to array (times,)
        t, y, psi, u, r of the voyage.
    """
    seen = {
        "speed": columns["u"],
        "abs_y": np.abs(columns["y"]),
        "abs_psi": np.abs(columns["psi"]),
        "abs_r": np.abs(columns["r"]),
    }
    found = [_sentence(name, getattr(known, name), seen[name], columns["t"]) for name in seen]
    return tuple(sentence for sentence in found if sentence)


def _sentence(name: str, covered: Range | None, values: np.ndarray, t: np.ndarray) -> str:
    if covered is None:
        return ""
    # A voyage at the very speed of the tests is inside, whatever rounding makes of it.
    slack = 1e-6 * max(abs(covered[0]), abs(covered[1]))
    outside = (values < covered[0] - slack) | (values > covered[1] + slack)
    if not outside.any():
        return ""
    word, unit, scale = WORDS[name]
    first = int(np.argmax(outside))
    low, high = (scale * end for end in covered)
    return (
        f"From {t[first]:.2f} s her {word} of {scale * values[first]:.3g} {unit} is outside the data "
        f"({low:.3g} to {high:.3g} {unit})."
    )
