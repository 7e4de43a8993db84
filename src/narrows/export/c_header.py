"""A model as one C99 header without dependencies."""

from collections.abc import Mapping

from narrows.codegen.choices import COLUMNS, ROW
from narrows.codegen.printers.c import CArithmetic, c_body, c_name
from narrows.codegen.printers.c_functions import CTranslation
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import (
    FATES,
    places_in,
    plain_functions,
    rate_names,
    rendered,
    results_of,
    targets_of,
    water_of,
)


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
        water=water_of(exported, c_number), number=c_number, c_name=c_name, rates=rate_names(exported), fates=FATES,
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
    printer, of = CArithmetic(exported.prefix), "{}->{}".format
    places = places_in(exported, of, "{}({})".format, c_name)
    bodies = {}
    for name, program in exported.programs.items():
        targets, where = targets_of(name, exported, of, c_name) or (results_of(program), places)
        bodies[name] = "\n    ".join(c_body(program, targets, where, printer))
    return bodies
