"""A model as one ES module without dependencies, its types as JSDoc."""

from narrows.codegen.printers.javascript import JavaScriptTranslation, javascript_body, javascript_name
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import bodies_of, rendered, translated, water_of


def javascript_text(exported: ExportedShip, derivatives: bool = True) -> str:
    """Return the module of a ship."""
    bodies = bodies_of(exported, "{}.{}".format, "Math.{}({})".format, javascript_name, javascript_body)
    return rendered(
        "model.js.j2", exported, f=bodies, water=water_of(exported, javascript_number), number=javascript_number,
        name=javascript_name, derivatives=derivatives, **translated(exported, JavaScriptTranslation),
    )  # fmt: skip


def javascript_number(value: float) -> str:
    """Return a number to its last bit."""
    text = repr(float(value))
    return {"inf": "Infinity", "-inf": "-Infinity", "nan": "NaN"}.get(text, text)
