"""A model as one C99 header without dependencies."""

from functools import partial

from narrows.codegen.printers.c import CArithmetic, c_body, c_name
from narrows.codegen.printers.c_block import c_block
from narrows.codegen.printers.c_functions import CTranslation
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import bodies_of, places_in, rendered, translated, water_of


def c_text(exported: ExportedShip) -> str:
    """Return the header of a ship."""
    printer = CArithmetic(exported.prefix)
    bodies = bodies_of(exported, "{}->{}".format, "{}({})".format, c_name, partial(c_body, printer=printer))
    bodies["step_block"] = "\n    ".join(_block(exported, printer))
    filling = ("fill_table",) if exported.waterway else ()
    return rendered(
        "model.h.j2", exported, f=bodies, water=water_of(exported, c_number), number=c_number, c_name=c_name,
        **translated(exported, partial(CTranslation, prefix=exported.prefix), *filling),
    )  # fmt: skip


def _block(exported: ExportedShip, printer: CArithmetic) -> list[str]:
    """The body of a step of many ships."""
    portable = exported.portable
    places = places_in(exported, "{}->{}".format, "{}({})".format, c_name)
    for column, rows in (("state", portable.kept), ("inputs", portable.inputs)):
        places |= {name: f"{column}[{number}][lane]" for number, name in enumerate(rows)}
    results = {
        f"state[{number}][lane]": portable.step.out[name]
        for number, name in enumerate((*portable.kept, "room", "lean"))
    }
    return c_block(portable.step.lines, results, places, printer, f"{exported.prefix.upper()}_LANES")


def c_number(value: float) -> str:
    """Return a number to its last bit."""
    text = repr(float(value))
    return {"inf": "INFINITY", "-inf": "-INFINITY", "nan": "NAN"}.get(text, text)
