"""A model as one C99 header without dependencies."""

from functools import partial

from narrows.codegen.printers.c import CArithmetic, c_body, c_name
from narrows.codegen.printers.c_functions import CTranslation
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import bodies_of, rendered, translated, water_of


def c_text(exported: ExportedShip) -> str:
    """Return the header of a ship (ours).

    Parameters
    ----------
    exported : ExportedShip
        The ship, its choices and its waterway.
    """
    body = partial(c_body, printer=CArithmetic(exported.prefix))
    bodies = bodies_of(exported, "{}->{}".format, "{}({})".format, c_name, body)
    return rendered(
        "model.h.j2", exported, f=bodies, water=water_of(exported, c_number), number=c_number, c_name=c_name,
        **translated(exported, partial(CTranslation, prefix=exported.prefix)),
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
