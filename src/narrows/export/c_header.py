"""A model as one C99 header without dependencies."""

from collections.abc import Mapping
from textwrap import wrap
from typing import Any

from narrows.codegen.choices import COLUMNS, ROW
from narrows.codegen.free_motion import STATE
from narrows.codegen.printers.c import WIDTH, CArithmetic, c_body, c_name
from narrows.codegen.printers.c_functions import CTranslation
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import plain_functions, rendered

FATES = ("AFLOAT", "GROUNDED", "DIVERGED", "OUTSIDE", "ASTERN", "PASSED")


def c_text(exported: ExportedShip) -> str:
    """Return the header of a ship (ours).

    Parameters
    ----------
    exported : ExportedShip
        The ship, its choices and its waterway.
    """
    source = plain_functions(exported)
    translation = CTranslation(source, exported.prefix)
    plain = [translation.text(one) for one in source.needed(*(("clearance",) * exported.exact), "sail")]
    stated = {*FATES, *(name.upper() for name in exported.portable.kept)}
    numbers = {name: source.constants[name] for name in sorted(translation.used - stated)}
    columns = [" ".join(name.split("_")) for name in COLUMNS]
    return rendered(
        "model.h.j2", exported, f=_bodies(exported), plain=plain, numbers=numbers, row=ROW, columns=columns,
        water=_water(exported), number=c_number, c_name=c_name, rates=rate_names(exported), fates=FATES,
    )  # fmt: skip


def c_number(value: float) -> str:
    """Return a number to its last bit (ours).

    Parameters
    ----------
    value : float
        Any.
    """
    text = repr(float(value))
    return {"inf": "INFINITY", "-inf": "-INFINITY", "nan": "NAN"}.get(text, text)


def _bodies(exported: ExportedShip) -> Mapping[str, str]:
    printer, places = CArithmetic(exported.prefix), places_in(exported, "->")
    bodies = {}
    for name, program in exported.programs.items():
        if name == "constants":
            targets = [f"constants->{c_name(constant)}" for constant in exported.constants]
            where: Mapping[str, str] = {one.name: f"parameters->{c_name(one.name)}" for one in exported.parameters}
        else:
            targets, where = [f"result[{number}]" for number in range(len(program.results))], places
        bodies[name] = "\n    ".join(c_body(program, targets, where, printer))
    return bodies


def places_in(exported: ExportedShip, of: str) -> dict[str, str]:
    """Return where lines find each number: in the state, the inputs, the constants, the waterway (ours).

    Parameters
    ----------
    exported : ExportedShip
        Whose lines.
    of : str
        Between a structure and its field.
    """
    portable = exported.portable
    places = {name: f"constants{of}{c_name(name)}" for name in exported.constants}
    places |= {name: f"state[{number}]" for number, name in enumerate(portable.kept)}
    for actuator in portable.geared:
        position = portable.kept.index(actuator.name)
        places |= {f"cos_{actuator.name}": f"cos(state[{position}])", f"sin_{actuator.name}": f"sin(state[{position}])"}
    names = zip(portable.inputs, exported.inputs, strict=True)
    places |= {name: f"inputs{of}{c_name(one.name)}" for name, one in names}
    places |= {name: f"waterway{of}{name}" for name in ("x_first", "x_last", "cells_a_metre", "last_cell")}
    # Derivatives by inputs may ask for what the step does not.
    return {"X_in": "0.0", "Y_in": "0.0", "N_in": "0.0", **places, "step_length": "step_length"}


def _water(exported: ExportedShip) -> dict[str, Any] | None:
    if exported.waterway is None:
        return None
    channel = exported.channel
    arrays = {"table": channel.water.table, "track": channel.water.track, "outline": channel.water.outline}
    text = {name: "\n    ".join(wrap(", ".join(map(c_number, values)), WIDTH)) for name, values in arrays.items()}
    places = {name: c_number(channel.inputs[name]) for name in ("x_first", "x_last", "cells_a_metre", "last_cell")}
    return {"arrays": text, "lengths": {name: len(values) for name, values in arrays.items()}, "places": places}


def rate_names(exported: ExportedShip) -> tuple[str, ...]:
    """Return what ``rates`` gives, in order (ours).

    Parameters
    ----------
    exported : ExportedShip
        Whose.
    """
    return tuple(name for name in exported.portable.kept if name in (*STATE, "counted_psi"))
