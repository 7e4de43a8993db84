"""The sliders of a page: the inputs of the model's terms, with ranges that suit the ship and the tested range."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from narrows.export.exported_ship import ExportedShip
from narrows.model.data_range import Range, tolerated
from narrows.model.model import SETTLED, Model

VOYAGE, CANAL, UNKNOWN = "The voyage", "The canal", "Uncertainty"
PICTURES, COEFFICIENTS = "The pictures", "Coefficients"
# Relative standard deviation of a coefficient if the model has no covariance.
ASSUMED = 0.05
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


def _voyage(exported: ExportedShip, speed: float, steered: bool) -> Iterator[Slider]:
    model = exported.ship.model
    ship, canal, known = model.configuration.ship, model.configuration.canal, model.data_range
    inputs, is_open, degree = {one.name: one.value for one in exported.inputs}, is_open_water(model), math.degrees(1.0)
    most = OFFSET * ship.length if is_open else (canal.width - ship.beam) / 2
    if steered:
        line = "dashed line" if is_open else "middle"
        yield Slider("helm", f"helm: hold the {line}", "", VOYAGE, 0, 1, 1, 0, switch=True)
    fine = _fine(speed / 50)
    yield Slider("u", "speed", "m/s", VOYAGE, _to(0.3 * speed, fine), _to(1.6 * speed, fine), fine, speed,
                 **_tested(model, known.speed, fine, "m/s"))  # fmt: skip
    off = _fine(most / 200)
    yield Slider("y", "start, to starboard", "m", VOYAGE, _to(-most, off), _to(most, off), off,
                 _to(min(most / 9, ship.length), off), **_tested(model, known.abs_y, off, "m", both=True))  # fmt: skip
    yield Slider("psi", "heading, to starboard", "°", VOYAGE, -12, 12, 0.1, 0,
                 **_tested(model, known.abs_psi, 0.1, "°", degree, both=True))  # fmt: skip
    if "rudder" in exported.kept:
        limit = math.floor(math.degrees(model.configuration.gear.limit))
        yield Slider("rudder", "rudder, to starboard", "°", VOYAGE, -limit, limit, 0.5, 0)
    if "revolutions" in inputs:
        n = inputs["revolutions"]
        turn = _fine(n / 100)
        fastest, astern = _to(2 * n, turn), getattr(model.configuration.propeller, "turns_astern", False)
        yield Slider("revolutions", "revolutions", "1/s", VOYAGE, -fastest if astern else 0, fastest, turn, n)
    low, high = _to(-0.25 * speed, fine), _to(0.5 * speed, fine)
    yield Slider("current", "current, from astern", "m/s", VOYAGE, low, high, fine, 0)


def _canal(model: Model, deep: bool) -> Iterator[Slider]:
    ship, canal, known = model.configuration.ship, model.configuration.canal, model.data_range
    if not is_open_water(model):
        fine = _fine(canal.width / 200)
        low, high = _to(NARROWEST * ship.beam, fine), _to(WIDEST * canal.width, fine)
        tested = _tested(model, known.width_to_beam, fine, "m", ship.beam)
        yield Slider(
            "width", "width", "m", CANAL, low, high, fine, canal.width, **tested, told="the width of the canal"
        )
    if deep and canal.depth:
        fine, deepest = _fine(ship.draft / 100), max(4 * ship.draft, canal.depth)
        low, high = _to(1.1 * ship.draft, fine), _to(deepest, fine)
        tested = _tested(model, known.depth_to_draft, fine, "m", ship.draft)
        yield Slider(
            "depth", "depth", "m", CANAL, low, high, fine, canal.depth, **tested, told="the depth of the canal"
        )


def _unknown(model: Model) -> Iterator[Slider]:
    fine, spread = _fine(model.configuration.ship.length / 800), START_SPREAD * model.configuration.ship.length
    yield Slider("sd_y", "spread of starts", "m", UNKNOWN, 0, _to(6 * spread, fine), fine, _to(spread, fine))
    yield Slider("sd_psi", "spread of headings", "°", UNKNOWN, 0, 3, 0.05, HEADING_SPREAD)
    yield Slider("doubt", "spread of coefficients", "×", UNKNOWN, 0, 3, 0.05, 1)
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


def _tested(
    model: Model, known: Range | None, fine: float, unit: str, scale: float = 1.0, both: bool = False
) -> dict[str, Any]:
    """Return the range that the data cover, and in words with whose data they are."""
    if known is None:
        return {}
    whose = "other ships" if model.source.estimate else "tested"
    words = f"{whose}: {_ends((scale * known[0], scale * known[1]), fine)}{'' if unit == '°' else ' '}{unit}"
    return {"tested": covered(known, scale, both), "beyond": words}


def _ends(known: Range, fine: float) -> str:
    return ("–" if known[0] >= 0 else " to ").join(dict.fromkeys(f"{_to(end, fine):g}" for end in known))


def _fine(size: float) -> float:
    """Return a step of 1, 2 or 5 times a power of ten, no larger."""
    power = 10.0 ** math.floor(math.log10(size))
    return float(f"{max(step for step in (1, 2, 5) if step * power <= size * (1 + 1e-9)) * power:.3g}")


def _to(value: float, fine: float) -> float:
    return float(f"{round(value / fine) * fine:.10g}")
