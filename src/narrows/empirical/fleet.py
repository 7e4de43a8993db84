"""Available ships: published models, and estimates from the dimensions of well-known ships."""

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, overload

from narrows.errors import InputError, did_you_mean
from narrows.model.model import Model
from narrows.model.model_file import load_model
from narrows.quantities.names import KNOT
from narrows.ship.particulars import Canal, Ship
from narrows.terms.term import TermKind

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class EstimatedShip:
    """A ship with printed particulars for an estimate."""

    ship: Ship
    canal: Canal
    kind: str
    source: str
    speed: float | None = None  # Service speed [m/s]


_SIMMAN = "particulars of SIMMAN 2008"

# The canals are examples: the Suez Canal as a rectangle 24 m deep for the largest, a dredged channel for the others.
ESTIMATED_SHIPS = MappingProxyType({
    "estimated_kcs": EstimatedShip(
        Ship(230.0, 32.2, 10.8, 0.651, name="KCS"), Canal(300.0, 16.2), "container", _SIMMAN, 24 * KNOT),
    "estimated_dtc": EstimatedShip(
        Ship(355.0, 51.0, 14.5, 0.661, name="DTC"), Canal(400.0, 24.0), "container", "el Moctar et al. (2012)"),
    "estimated_kvlcc2": EstimatedShip(
        Ship(320.0, 58.0, 20.8, 0.810, name="KVLCC2"), Canal(400.0, 30.0), "tanker", _SIMMAN, 15.5 * KNOT),
    "estimated_esso_osaka": EstimatedShip(
        Ship(325.0, 53.0, 21.73, 0.831, name="Esso Osaka"), Canal(400.0, 32.6), "tanker", "Crane (1979)"),
    "estimated_400m": EstimatedShip(
        Ship(400.0, 58.8, 16.0, 0.68, name="container ship of 400 m"), Canal(300.0, 24.0), "container",
        "dimensions of the largest container ships of 2021; the block coefficient is assumed"),
    "estimated_bulk": EstimatedShip(
        Ship(289.0, 45.0, 18.0, 0.84, name="capesize bulk carrier"), Canal(300.0, 22.5), "bulk", "usual dimensions"),
    "estimated_inland": EstimatedShip(
        Ship(110.0, 11.45, 2.8, 0.88, name="inland motor ship of 110 m"), Canal(55.0, 4.0), "inland",
        "class Va of the European waterways"),
})  # fmt: skip


@cache
def _printed() -> dict[str, Path]:
    folder = files("narrows") / "model" / "published"
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".toml"))
    return {name.removesuffix(".toml"): Path(str(folder / name)) for name in names}


def _ready_ships() -> dict[str, Callable[[], Model]]:
    printed = {name: lambda path=path: load_model(path) for name, path in _printed().items()}
    estimates = {name: lambda row=row: _estimate(row) for name, row in ESTIMATED_SHIPS.items()}
    return {**printed, **estimates}


def _estimate(row: EstimatedShip) -> Model:
    from narrows.empirical.main_dimensions import estimate_model  # Its statistics load slowly

    return estimate_model(row.ship, row.canal, kind=row.kind, speed=row.speed)


@overload
def published() -> list[str]:
    """List the names of the available ships."""


@overload
def published(name: str) -> Model:
    """Load an available ship.

    Parameters
    ----------
    name : str
        As in ``mikkelsen2025_dtc``.
    """


def published(name: str | None = None) -> "Model | list[str]":
    """Load an available ship, or list their names.

    The names begin with the paper of their coefficients, or with ``estimated``.

    Parameters
    ----------
    name : str, optional
        As in ``mikkelsen2025_dtc``; all names unless given.

    Returns
    -------
    Model or list of str
        With its citation in ``source``; or the names.

    Raises
    ------
    InputError
        If no such ship is known.

    Examples
    --------
    >>> nw.published("mikkelsen2025_dtc").ship.name
    'DTC 1:89.11'
    """
    ready = _ready_ships()
    if name is None:
        return list(ready)
    if name not in ready:
        raise InputError(f"no published model is called {name!r}{did_you_mean(name, ready)}")
    return ready[name]()


def model_named(name: str, width: float | None = None, depth: float | None = None) -> Model:
    """Return a model by its file or name, in a canal of another width and depth [m] if given."""
    sizes = {"width": width, "depth": depth}
    given = {side: size for side, size in sizes.items() if size is not None}
    if given and name in ESTIMATED_SHIPS:  # Its formulas take the depth.
        row = ESTIMATED_SHIPS[name]
        return _estimate(replace(row, canal=replace(row.canal, **given)))
    model = load_model(name) if "." in name or "/" in name or os.path.exists(name) else published(name)
    return model.with_canal(**given) if given else model


def ready_ships() -> "pd.DataFrame":
    """List the available ships: dimensions, source, and measured parts.

    Returns
    -------
    DataFrame
        One row per ship, with the name for ``published``.

    Examples
    --------
    >>> "estimated_kcs" in nw.ready_ships().index
    True
    """
    import pandas as pd

    rows = {name: _row(name, published(name)) for name in published()}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("name")


def _row(name: str, model: Model) -> dict[str, object]:
    ship, terms = model.configuration.ship, model.terms
    source = ESTIMATED_SHIPS[name].source if name in ESTIMATED_SHIPS else model.source.text
    return {
        "ship": ship.name,
        "length": ship.length,
        "beam": ship.beam,
        "draft": ship.draft,
        "block_coefficient": ship.block_coefficient,
        "rudder": any(term.kind is TermKind.RUDDER for term in terms.terms),
        "banks": model.has_bank,
        "measured": "nothing of this ship" if model.source.estimate else "captive tests",
        "source": source,
    }
