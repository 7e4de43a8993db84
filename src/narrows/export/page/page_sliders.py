"""The sliders of a page: the inputs of the model's terms, with ranges that suit the ship and the tested range."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from narrows.export.exported_ship import ExportedShip
from narrows.model.data_range import Range, tolerated
from narrows.model.model import SETTLED, Model

VOYAGE, CANAL, UNKNOWN = "The voyage", "The canal", "Uncertainty"
PICTURES, COEFFICIENTS = "The pictures", "Coefficients"
ASSUMED = 0.05  # Relative standard deviation of a coefficient if the model has no covariance
# Range of a coefficient's slider [standard deviations]; canal widths: least [beams], most relative to the model's own.
WIDE, NARROWEST, WIDEST = 3.0, 1.6, 2.0
# Standard deviation of the starting offset [ship lengths] and of the heading [degrees].
START_SPREAD, HEADING_SPREAD = 0.0125, 0.5
# Open water: clearance to either bank, and largest starting offset [ship lengths]; a voyage is 7 long.
CLEARANCE, OFFSET = 10.0, 2.0


@dataclass(frozen=True)
class Slider:
    name: str  # Name in the address
    label: str
    unit: str
    group: str  # Heading above it
    low: float
    high: float
    step: float
    value: float  # First value
    tested: Range | None = None  # Range of the data
    beyond: str | None = None  # That range in words, for a value beyond it
    told: str | None = None  # Name in the list of values beyond the data
    switch: bool = False  # True for an on-off switch

    def to_dict(self) -> dict[str, Any]:
        digits = max(0, -math.floor(math.log10(self.step) + 1e-9))
        values = {name: value for name, value in asdict(self).items() if value is not None and value is not False}
        return values | {"digits": digits}


def is_open_water(model: Model) -> bool:
    """Return whether a model has no bank force, and the banks of its canal are out of reach."""
    ship = model.configuration.ship
    return not model.has_bank and model.configuration.canal.width > 2 * CLEARANCE * ship.length


def sliders_of(exported: ExportedShip, speed: float, steered: bool) -> list[Slider]:
    model = exported.ship.model
    names = {parameter.name for parameter in exported.parameters}
    return [
        *_voyage(exported, speed, steered), *_canal(model, "depth" in names), *_unknown(model),
        *(coefficient for term in model.terms.names if term in names for coefficient in [_coefficient(model, term)]),
    ]  # fmt: skip


def _slider(
    model: Model, group: str, name: str, label: str, unit: str, ends: Range, fine: float, value: float,
    known: Range | None = None, scale: float = 1.0, both: bool = False, told: str | None = None,
) -> Slider:  # fmt: skip
    """Return a slider by its step, with the range of the data: ``known`` times ``scale``, of ``both`` signs."""
    words = None
    if known is not None:
        whose = "other ships" if model.source.estimate else "tested"
        words = f"{whose}: {_ends((scale * known[0], scale * known[1]), fine)}{'' if unit == '°' else ' '}{unit}"
    low, high = (_to(end, fine) for end in ends)
    return Slider(name, label, unit, group, low, high, fine, value, covered(known, scale, both), words, told)


def _voyage(exported: ExportedShip, speed: float, steered: bool) -> Iterator[Slider]:
    model = exported.ship.model
    ship, canal, known = model.configuration.ship, model.configuration.canal, model.data_range
    inputs, is_open, degree = {one.name: one.value for one in exported.inputs}, is_open_water(model), math.degrees(1.0)
    most, slider = OFFSET * ship.length if is_open else (canal.width - ship.beam) / 2, partial(_slider, model, VOYAGE)
    if steered:
        line = "dashed line" if is_open else "middle"
        yield Slider("helm", f"helm: hold the {line}", "", VOYAGE, 0, 1, 1, 0, switch=True)
    fine, off = _fine(speed / 50), _fine(most / 200)
    yield slider("u", "speed", "m/s", (0.3 * speed, 1.6 * speed), fine, speed, known.speed)
    start = _to(min(most / 9, ship.length), off)
    yield slider("y", "start, to starboard", "m", (-most, most), off, start, known.abs_y, both=True)
    yield slider("psi", "heading, to starboard", "°", (-12, 12), 0.1, 0, known.abs_psi, degree, both=True)
    if "rudder" in exported.kept:
        limit = math.floor(math.degrees(model.configuration.gear.limit))
        yield slider("rudder", "rudder, to starboard", "°", (-limit, limit), 0.5, 0)
    if "revolutions" in inputs:
        n = inputs["revolutions"]
        astern = getattr(model.configuration.propeller, "turns_astern", False)
        yield slider("revolutions", "revolutions", "1/s", (-2 * n if astern else 0, 2 * n), _fine(n / 100), n)
    yield slider("current", "current, from astern", "m/s", (-0.25 * speed, 0.5 * speed), fine, 0)


def _canal(model: Model, deep: bool) -> Iterator[Slider]:
    ship, canal, known = model.configuration.ship, model.configuration.canal, model.data_range
    slider = partial(_slider, model, CANAL)
    if not is_open_water(model):
        yield slider("width", "width", "m", (NARROWEST * ship.beam, WIDEST * canal.width), _fine(canal.width / 200),
                     canal.width, known.width_to_beam, ship.beam, told="the width of the canal")  # fmt: skip
    if deep and canal.depth:
        ends = 1.1 * ship.draft, max(4 * ship.draft, canal.depth)
        yield slider("depth", "depth", "m", ends, _fine(ship.draft / 100), canal.depth, known.depth_to_draft,
                     ship.draft, told="the depth of the canal")  # fmt: skip


def _unknown(model: Model) -> Iterator[Slider]:
    slider, length = partial(_slider, model, UNKNOWN), model.configuration.ship.length
    fine, spread = _fine(length / 800), START_SPREAD * length
    yield slider("sd_y", "spread of starts", "m", (0, 6 * spread), fine, _to(spread, fine))
    yield slider("sd_psi", "spread of headings", "°", (0, 3), 0.05, HEADING_SPREAD)
    yield slider("doubt", "spread of coefficients", "×", (0, 3), 0.05, 1)
    yield Slider("ships", "ships", "", PICTURES, 500, 10_000, 500, 3000)
    if not is_open_water(model):
        yield Slider("map", "map, cells across", "", PICTURES, 40, 240, 20, 200)


def deviation(model: Model, name: str) -> float:
    """Return the standard deviation of a coefficient, or the assumed one without a covariance."""
    if model.covariance is None:
        return ASSUMED * abs(model.coefficients[name])
    place = model.terms.names.index(name)
    return float(np.sqrt(model.covariance[place, place]))


def _coefficient(model: Model, name: str) -> Slider:
    value, bound = model.coefficients[name], model.terms[name].bound
    size = WIDE * deviation(model, name) or abs(value) or 1.0
    size = max(size, abs(value) if model.covariance is None else 0.0)
    low, high = max(value - size, bound[0]), min(value + size, bound[1])
    verdict = model.verdicts.get(name, "no verdict")
    unit = model.terms[name].dimension.unit
    inside = None if model.covariance is None else (value - 2 * size / WIDE, value + 2 * size / WIDE)
    label, fine = name if verdict == SETTLED else f"{name}, {verdict}", _fine(size / 100)
    words = None if inside is None else f"interval: {_ends(inside, fine)}"
    return Slider(name, label, "" if unit == "1" else unit, COEFFICIENTS, low, high, fine, value,
                  inside, words, name)  # fmt: skip


def covered(known: Range | None, scale: float = 1.0, both: bool = False) -> Range | None:
    """Return the range of the data; of ``both`` signs where they limit an absolute value."""
    if known is None:
        return None
    low, high = tolerated(known)
    return -scale * high if both else scale * low, scale * high


def _ends(known: Range, fine: float) -> str:
    return ("–" if known[0] >= 0 else " to ").join(dict.fromkeys(f"{_to(end, fine):g}" for end in known))


def _fine(size: float) -> float:
    """Return a step of 1, 2 or 5 times a power of ten, no larger."""
    power = 10.0 ** math.floor(math.log10(size))
    return float(f"{max(step for step in (1, 2, 5) if step * power <= size * (1 + 1e-9)) * power:.3g}")


def _to(value: float, fine: float) -> float:
    return float(f"{round(value / fine) * fine:.10g}")
