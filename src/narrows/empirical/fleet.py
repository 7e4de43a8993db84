"""Available ships: published models, and estimates from the dimensions of well-known ships."""

import os
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from narrows.base.errors import InputError, did_you_mean
from narrows.model.model import Model
from narrows.model.sections import load_model
from narrows.model.term import TermKind
from narrows.quantities.names import KNOT
from narrows.ship.particulars import Canal, Ship

if TYPE_CHECKING:
    import pandas as pd


PUBLISHED = Path(__file__).parents[1] / "model" / "published"
ESTIMATED: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def _estimate(name: str, **sizes: float) -> Model:
    from narrows.empirical.main_dimensions import estimate_model  # SciPy's statistics load slowly

    row = ESTIMATED[name]
    speed = row.get("speed_knots", 0.0) * KNOT or None
    return estimate_model(Ship(**row["ship"]), Canal(**(row["canal"] | sizes)), kind=row["kind"], speed=speed)


@overload
def published() -> list[str]: ...
@overload
def published(name: str) -> Model: ...
def published(name: str | None = None) -> "Model | list[str]":
    """Load an available ship, or list their names.

    The names begin with the paper of their coefficients, or with ``estimated``. A model has its citation in ``source``.
    Raises an InputError if no such ship is known.

    Parameters
    ----------
    name : str, optional
        Name of the ship, as ``mikkelsen2025_dtc``; the names of all ships unless given.

    Examples
    --------
    >>> nw.published("mikkelsen2025_dtc").ship.name
    'DTC 1:89.11'
    """
    names = [*sorted(path.stem for path in PUBLISHED.glob("*.toml")), *ESTIMATED]
    if name is None:
        return names
    if name not in names:
        raise InputError(f"no published model is called {name!r}{did_you_mean(name, names)}")
    return _estimate(name) if name in ESTIMATED else load_model(PUBLISHED / f"{name}.toml")


def model_named(name: str, width: float | None = None, depth: float | None = None) -> Model:
    """Return a model by its file or name, in a canal of another width and depth [m] if given."""
    changes = {size: value for size, value in (("width", width), ("depth", depth)) if value is not None}
    if name in ESTIMATED:  # The formulas of an estimate depend on depth.
        return _estimate(name, **changes)
    model = load_model(name) if "." in name or "/" in name or os.path.exists(name) else published(name)
    return model.with_canal(**changes) if changes else model


def ready_ships() -> "pd.DataFrame":
    """List the available ships, a row each by the name for ``published``: dimensions, source, and measured parts.

    >>> "estimated_kcs" in nw.ready_ships().index
    True
    """
    return table_of_ships(published())


def table_of_ships(names: Iterable[str]) -> "pd.DataFrame":
    """Return a row for each model file or published name."""
    import pandas as pd

    rows = {}
    for name, model in ((name, model_named(name)) for name in names):
        ship = model.configuration.ship
        rows[name] = {
            "ship": ship.name,
            **{size: getattr(ship, size) for size in ("length", "beam", "draft", "block_coefficient")},
            "rudder": any(term.kind is TermKind.RUDDER for term in model.terms.terms),
            "banks": model.has_bank,
            "measured": "nothing of this ship" if model.source.estimate else "captive tests",
            "source": ESTIMATED[name]["source"] if name in ESTIMATED else model.source.text,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("name")
