"""What a page knows of its ship: numbers in the order of the exported model, sliders, caveats."""

from typing import Any

import numpy as np

from narrows.codegen.printers.javascript import javascript_name
from narrows.export.exported_ship import ExportedShip
from narrows.export.page.page_sliders import ASSUMED, COEFFICIENTS, Slider, both_ways, covered, deviation, sliders_of
from narrows.model.model import Model

# Ship lengths that are looked at.
LENGTHS = 7.0
# Of fleet.c: ships of a task, those whose paths are kept, and points of a path.
MOST, PATHS, SAMPLES = 4096, 1024, 96
UNSURE = "The coefficients have no published uncertainty; an assumed one spreads the ships"


def page_data(exported: ExportedShip, speed: float, title: str) -> dict[str, Any]:
    """Return everything that the scripts of a page ask for."""
    # speed [m/s]
    model, kept = exported.ship.model, exported.portable.kept
    ship, sliders = model.configuration.ship, sliders_of(exported, speed, exported.steering is not None)
    names = [slider.name for slider in sliders if slider.group == COEFFICIENTS]
    speeds = next(slider for slider in sliders if slider.name == "u")
    return {
        "title": title, "picture": "narrows.png", "lengths": LENGTHS,
        "ship": {"length": ship.length, "beam": ship.beam},
        "shape": {
            "states": len(kept), "parameters": len(exported.parameters), "most": MOST, "paths": PATHS,
            "samples": SAMPLES, "rudder": kept.index("rudder") if "rudder" in kept else -1,
        },
        "names": {
            "parameters": [javascript_name(one.name) for one in exported.parameters],
            "inputs": [javascript_name(one.name) for one in exported.inputs],
        },
        "parameters": [one.value for one in exported.parameters], "inputs": [one.value for one in exported.inputs],
        "coefficients": [{"name": name, "bounds": _bounds(model, name)} for name in names],
        "root": _written(root_of(model, names)), "share": ASSUMED,
        "assumed": UNSURE if model.covariance is None else "",
        "sliders": [slider.to_dict() for slider in sliders], "speeds": [speeds.low, speeds.high],
        "tested": {"u": covered(model.data_range.speed), "y": both_ways(model.data_range.abs_y)},
        "notes": _notes(model, sliders),
    }  # fmt: skip


def _written(root: np.ndarray) -> list[Any]:
    """The rows of a matrix to ten digits; its diagonal alone where there is nothing else."""
    diagonal = np.diag(root)
    if np.array_equal(root, np.diag(diagonal)):
        return [float(f"{value:.10g}") for value in diagonal]
    return [[float(f"{value:.10g}") for value in row] for row in root]


def _bounds(model: Model, name: str) -> list[float | None]:
    return [float(end) if np.isfinite(end) else None for end in model.terms[name].bound]


def _notes(model: Model, sliders: list[Slider]) -> list[str]:
    """What the model says of itself, and what its data do not say."""
    said = {slider.name for slider in sliders if slider.tested}
    unsaid = [words for name, words in (("u", "speeds"), ("y", "offsets")) if name not in said]
    silent = f"The model does not say which {' and '.join(unsaid)} its tests covered." if unsaid else ""
    return [*model.notes, *filter(None, [silent])]


def root_of(model: Model, names: list[str]) -> np.ndarray:
    """Return the symmetric root of the covariance of some coefficients, by their correlations as in ``samples``."""
    size = np.array([deviation(model, name) for name in names])
    if model.covariance is None:
        return np.diag(size)
    places = [model.terms.names.index(name) for name in names]
    scale = np.where(size > 0, size, 1.0)
    share, axes = np.linalg.eigh(model.covariance[np.ix_(places, places)] / np.outer(scale, scale))
    return np.asarray((axes * np.sqrt(np.maximum(share, 0.0))) @ axes.T * size)
