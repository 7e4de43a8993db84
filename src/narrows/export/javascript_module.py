"""A model as one ES module without dependencies, its types as JSDoc."""

from collections.abc import Mapping

from narrows.codegen.choices import COLUMNS, ROW
from narrows.codegen.printers.javascript import JavaScriptTranslation, javascript_body, javascript_name
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


def javascript_text(exported: ExportedShip) -> str:
    """Return the module of a ship (ours).

    Parameters
    ----------
    exported : ExportedShip
        The ship, its choices and its waterway.
    """
    source = plain_functions(exported)
    translation = JavaScriptTranslation(source)
    plain = [translation.text(one) for one in source.needed(*(("clearance",) * exported.exact), "sail")]
    stated = {*FATES, *(name.upper() for name in exported.portable.kept)}
    numbers = {name: source.constants[name] for name in sorted(translation.used - stated)}
    columns = [" ".join(name.split("_")) for name in COLUMNS]
    return rendered(
        "model.js.j2", exported, f=_bodies(exported), plain=plain, numbers=numbers, row=ROW, columns=columns,
        water=water_of(exported, javascript_number), number=javascript_number, name=javascript_name,
        rates=rate_names(exported), fates=FATES,
    )  # fmt: skip


def javascript_number(value: float) -> str:
    """Return a number to its last bit (ours).

    Parameters
    ----------
    value : float
        Any.
    """
    text = repr(float(value))
    return {"inf": "Infinity", "-inf": "-Infinity", "nan": "NaN"}.get(text, text)


def _bodies(exported: ExportedShip) -> Mapping[str, str]:
    of = "{}.{}".format
    places = places_in(exported, of, "Math.{}({})".format, javascript_name)
    bodies = {}
    for name, program in exported.programs.items():
        targets, where = targets_of(name, exported, of, javascript_name) or (results_of(program), places)
        bodies[name] = "\n    ".join(javascript_body(program, targets, where))
    return bodies
