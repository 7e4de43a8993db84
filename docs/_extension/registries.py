"""What the package can be added to: a row a member, from the registries that everything else reads."""

import inspect
import re
from collections.abc import Iterable, Iterator
from typing import Any

from _extension.markdown import table
from narrows.captive.layouts import LAYOUTS
from narrows.estimation.sensors import SENSORS
from narrows.export import EXPORTERS
from narrows.logbook.checking.check_log import RECORD_CHECKS
from narrows.logbook.checking.faults import FAULTS
from narrows.safety.pilots import PILOTS
from narrows.simulation.controllers import CONTROLLERS

LENGTH = 4.0
"""Of the ship that the controllers' examples are for [m]."""


def text() -> str:
    """Write a table a registry."""
    return "\n\n".join(f"## {title}\n\n{table(header, rows)}" for title, header, rows in _parts())


def _parts() -> Iterator[tuple[str, tuple[str, ...], Iterable[tuple[str, ...]]]]:
    laws = [(name, type(example(LENGTH))) for name, example in CONTROLLERS.items()]
    yield (
        "Controllers",
        ("class", "what it does"),
        [(f"`nw.controllers.{law.__name__}`", _said(law)) for _, law in laws],
    )
    pilots = [(f"`{name}`", pilot.words) for name, pilot in PILOTS.items()]
    yield "Pilots of the safe envelope", ("`--controller`", "who it is"), pilots
    sensors = [(f"`nw.estimation.{own.__name__}`", f"`{name}`", _said(own)) for name, own in SENSORS.items()]
    yield "Sensors", ("class", "name of its readings", "what it measures"), sensors
    layouts = [(f"`{own.__name__}`", _said(own)) for own in LAYOUTS]
    yield "Layouts of tables", ("layout", "whose tables"), layouts
    exporters = [(f"`{kind}`", ", ".join(own.suffixes), own.words) for kind, own in EXPORTERS.items()]
    yield "Exporters", ("`narrows export`", "file", "what it is"), exporters
    checks = [(f"`{own.__name__}`", _said(own)) for own in RECORD_CHECKS]
    yield "Checks of single records", ("check", "what it finds"), checks
    faults = [(f"`{name}`", *map(_with_places, sentence_and_remedy)) for name, sentence_and_remedy in FAULTS.items()]
    yield "Faults with a score test", ("fault", "what is found", "remedy"), faults


def _with_places(sentence: str) -> str:
    """A template with the names of its fields in italics."""
    return re.sub(r"\{(\w+)[^}]*\}", r"*\1*", sentence)


def _said(thing: Any) -> str:
    """The first line of what it says of itself."""
    return (inspect.getdoc(thing) or "").partition("\n")[0].replace("``", "`")
