"""What files of all languages have alike: plain functions as their source, templates, comments that stay comments."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

from narrows.codegen.printers.plain_source import PlainSource
from narrows.export.exported_ship import ExportedShip

PLAIN = ("narrows.codegen.kernels.event", "narrows.waterway.room", "narrows.codegen.kernels.single")
"""Modules of plain functions: the rule that closes a voyage, the banks of a waterway, one vessel to its end."""


def plain_functions(exported: ExportedShip) -> PlainSource:
    """Return the plain functions that a file ends with (ours).

    Parameters
    ----------
    exported : ExportedShip
        Whose.
    """
    absent = frozenset() if exported.waterway else frozenset({"waterway"})
    return PlainSource(tuple(map(text_of, PLAIN)), exported.rule, absent)


def text_of(module: str) -> str:
    """Return the text of a module of the package (ours).

    Parameters
    ----------
    module : str
        Its name.
    """
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).read_text(encoding="utf-8")


def commented(text: str) -> str:
    """Return words that cannot end the comment that they stand in, nor begin another (ours).

    Parameters
    ----------
    text : str
        Of a file: a name, a source.
    """
    plain = " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
    return plain.replace("\\", "|").replace("??", "? ?").replace("*/", "* /").replace("/*", "/ *")


def rendered(template: str, exported: ExportedShip, **told: Any) -> str:
    """Return a template with the numbers of a ship (ours).

    Parameters
    ----------
    template : str
        Its name.
    exported : ExportedShip
        The ship.
    **told : Any
        What else it asks for.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader("narrows.export", "templates")
    environment = Environment(loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["commented"] = commented
    environment.filters["set_in"] = _set_in
    text = environment.get_template(template).render(ship=exported, prefix=exported.prefix, **told)
    return text.rstrip() + "\n"


def _set_in(text: str, by: str = "    ") -> str:
    return text.replace("\n", f"\n{by}")
