"""A model at two scales, side by side."""

from typing import Any

from rich.console import Console
from rich.table import Table

from narrows.model.froude import Scaled
from narrows.model.model import Model
from narrows.model.nondimensional import nondimensional


def scaled_summary(old: Model, scaled: Scaled) -> dict[str, Any]:
    """Everything as plain numbers and words: what ``scale --json`` prints (ours).

    Parameters
    ----------
    old : Model
        As it was.
    scaled : Scaled
        As it is now.
    """
    return {
        "ratio": scaled.ratio,
        "speed_ratio": scaled.speed(1.0),
        "coefficients": {
            name: {"old": old.coefficients[name], "new": value, "unit": old.terms[name].dimension.unit}
            for name, value in scaled.model.coefficients.items()
        },
        "bis": nondimensional(scaled.model, "bis"),
        "summary": _sentence(scaled),
        "notes": list(scaled.warnings),
    }


def print_scaled(old: Model, scaled: Scaled) -> None:
    """Print a model at two scales and what does not go with it.

    Parameters
    ----------
    old : Model
        As it was.
    scaled : Scaled
        As it is now.
    """
    console = Console(highlight=False)
    bare = nondimensional(scaled.model, "bis")
    table = Table(box=None, pad_edge=False)
    for header in ("", "was", "is", "unit", "bis \\[1]"):
        table.add_column(header, justify="left" if header in ("", "unit") else "right", no_wrap=True)
    for name, value in scaled.model.coefficients.items():
        unit = old.terms[name].dimension.unit
        table.add_row(name, f"{old.coefficients[name]:.4g}", f"{value:.4g}", unit, f"{bare[name]:.4g}")
    console.print(table)
    console.print(_sentence(scaled))
    for warning in scaled.warnings:
        console.print(f"- {warning}")


def _sentence(scaled: Scaled) -> str:
    return f"Lengths times {scaled.ratio:.4g}, speeds and times times {scaled.speed(1.0):.4g} (Froude)."
