"""Safe envelopes and speed limits along a waterway, place by place."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import BaseResult
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.safety import settings
from narrows.safety.envelope import safe_envelope
from narrows.safety.headline import estimated, runs, safe_offsets
from narrows.safety.request import default_offsets, default_speeds
from narrows.safety.result import SafeEnvelope, noting
from narrows.ship.particulars import Ship
from narrows.simulation.inputs import check_waterway
from narrows.simulation.outcome import water_notes
from narrows.waterway.centreline import check_along_only
from narrows.waterway.waterway import STATIONS

if TYPE_CHECKING:
    import pandas as pd

    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True, repr=False)
class EnvelopeAlong(BaseResult):
    """The safe envelopes of some places along a waterway."""

    waterway: "Waterway"
    draft: float  # Draft of the ship [m]
    places: np.ndarray  # (n,) Places along it [m]
    computed_at: np.ndarray  # (n,) The tightest section of the reach of each place [m]
    middles: np.ndarray  # (n,) Middle of that section, to starboard of the line [m]
    envelopes: tuple[SafeEnvelope, ...]  # The envelope there; its offsets are from that middle

    def __repr__(self) -> str:
        return f"<EnvelopeAlong {self.waterway.name}, {len(self.places)} places>"

    @property
    def notes(self) -> tuple[str, ...]:
        reach = "each place stands for the reach midway to its neighbours, computed at its tightest section"
        return tuple(dict.fromkeys((reach, *(note for one in self.envelopes for note in one.notes))))

    @property
    def untested(self) -> str:
        """Reasons why the results are extrapolated; empty if every section was tested."""
        reasons = list(dict.fromkeys(one.untested for one in self.envelopes if one.untested))
        more = [f"and {len(reasons) - 1} other sections"] if len(reasons) > 1 else []
        return "; ".join([*reasons[:1], *more])

    def rows(self) -> list[dict[str, Any]]:
        """Return one row per place: banks and safe offsets off the line [m], speeds [knots], what limits the speed."""
        columns = (self.places.tolist(), self.computed_at.tolist(), self.middles.tolist(), self.envelopes)
        return [_row(*there) for there in zip(*columns, strict=True)]

    def edges(self) -> np.ndarray:
        """Return the ends of the reaches (n + 1,) [m]: midway between the places, and those of the waterway."""
        return _edges(self.waterway, self.places)

    def banks(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return where a keel meets the banks along the waterway [m]: distance, and port and starboard off the line."""
        s = _nodes(self.waterway, self.edges())
        room = self.waterway.section(s, self.draft)
        return s, room.middle - room.width / 2, room.middle + room.width / 2

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the rows as a table by distance."""
        import pandas as pd

        return pd.DataFrame(self.rows()).set_index("distance")

    def dataset(self) -> xr.Dataset:
        """Return the rows over the distance, with units."""
        found = xr.Dataset.from_dataframe(self.to_dataframe().astype({"limited_by": str}))
        for name in map(str, set(found.variables) - {"limited_by"}):
            found[name].attrs["units"] = "kn" if "speed" in name else "m"
        return found.assign_attrs(summary=self.summary(), notes="\n".join(self.notes))

    def summary(self) -> str:
        rows = self.to_dataframe()
        tested = rows["highest_speed"].dropna()
        others = rows["highest_speed_by_model"].drop(tested.index)
        by_model, nowhere = others.dropna(), ", ".join(f"{place:.0f}" for place in others.index[others.isna()])
        where, many = f"Along {self.waterway.name}, {len(rows)} places", f"{len(tested)} of them{_ends(tested)}"
        sentences = [*estimated(self.envelopes[0].data), f"{where}: safe with 95 % probability at {many}."]
        if len(by_model):
            more = f"at {len(by_model)} more{_ends(by_model)}"
            sentences.append(f"By the model alone, which was not tested there, {more}.")
        sentences += [f"No speed and offset is safe at {nowhere} m."] * bool(nowhere)
        sentences += [f"Not tested: {self.untested}."] * bool(self.untested)
        return " ".join(filter(None, (*sentences, *dict.fromkeys(one.trust for one in self.envelopes))))

    def to_dict(self) -> dict[str, Any]:
        first = self.envelopes[0]
        return {
            "summary": self.summary(), "waterway": self.waterway.name, "weather": first.weather, "pilot": first.pilot,
            "untested": self.untested, "places": self.rows(), "notes": list(self.notes),
        }  # fmt: skip


@accept_aliases
def envelope_along(model: Model, waterway: "Waterway", places: Sequence[float], **envelope: Any) -> EnvelopeAlong:
    """Find the highest safe speed and the widest safe offsets at places along a waterway.

    Each place stands for the reach midway to its neighbours. The safe envelope is computed in the tightest section of
    that reach: least free width (less what the hull sweeps in a bend) times water under the keel. By default
    it has nine offsets, nine speeds and those where the tests end. The answer of each of the ``envelopes`` names what
    the number of samples leaves uncertain; the summary does not.

    Raises an InputError if places are not on the waterway or do not rise, or the ship or an option does not fit.

    Parameters
    ----------
    model, waterway, places : Model, Waterway, sequence of float [m]
        A model at the ship's own size, with the terms of a rudder; rising places along the waterway.
    **envelope : Any
        Options of ``safe_envelope``; offsets are from the middle of each section.
    """
    check_waterway(waterway)
    along = np.atleast_1d(np.asarray(places, float))
    if waterway is None or not along.size or not (np.diff(along) > 0).all():
        raise InputError("envelopes along a waterway need one, and places along it that rise; give them")
    if not (along[0] >= 0 and along[-1] <= waterway.line.length):
        raise InputError(f"a place is beyond {waterway.name}, 0 to {waterway.line.length:.0f} m; choose places on it")
    tightest = _tightest(model.configuration.ship, waterway, along)
    reaches = [reach_at(model, waterway, place) for place in tightest.tolist()]
    water, known, found = water_notes(waterway, model.configuration.canal.depth), dict[Any, SafeEnvelope](), []
    for there, _, asked in reaches:  # A canal of one section, bend and current (to six digits) has one envelope.
        canal, options = there.configuration.canal, {**asked, **envelope}
        numbers = canal.width, canal.depth or math.nan, *asked["walls"], asked["curvature"], asked["current"]
        if (key := tuple(f"{number + 0.0:.6g}" for number in numbers)) not in known:
            if options.get("y") is None:
                options["y"] = default_offsets(there, options["walls"], settings.ALONG_OFFSETS)
            if options.get("u") is None:
                options["u"] = default_speeds(there, settings.ALONG_SPEEDS)
            known[key] = noting(safe_envelope(there, **options), *water)
        found.append(known[key])
    middles, draft = np.array([reach.middle for reach in reaches]), model.configuration.ship.draft
    return EnvelopeAlong(waterway, draft, along, tightest, middles, tuple(found))


def _edges(waterway: "Waterway", places: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], (places[:-1] + places[1:]) / 2, [waterway.line.length]])


def _nodes(waterway: "Waterway", more: np.ndarray) -> np.ndarray:
    """Evenly spaced places, every corner of banks and depths, and more (n,) [m]."""
    length, depths = waterway.line.length, [] if waterway.depths is None else [waterway.depths[0]]
    even = np.linspace(0, length, STATIONS)
    return np.unique(np.clip(np.concatenate([even, waterway.starboard.s, waterway.port.s, *depths, more]), 0, length))


def _tightest(ship: Ship, waterway: "Waterway", places: np.ndarray) -> np.ndarray:
    """Section of each reach with the least free width times water under the keel (n,) [m]; at ties the place."""
    edges = _edges(waterway, places)
    s = _nodes(waterway, np.concatenate([places, edges]))
    room = waterway.section(s, ship.draft)
    # A hull in a bend sweeps the height of its chord more, L^2 / (8 R). An unknown depth counts as constant.
    swept = ship.length**2 * np.abs(room.curvature) / 8
    under = np.nan_to_num(room.depth - ship.draft, nan=1.0)
    free = np.maximum(room.width - ship.beam - swept, 0.0) * np.maximum(under, 0.0)
    found = []
    for place, low, high in zip(places, edges, edges[1:], strict=False):
        inside = np.flatnonzero((s >= low) & (s <= high))
        least, here = inside[free[inside].argmin()], np.searchsorted(s, place)
        found.append(place if free[here] <= (1 + settings.SAME_ROOM) * free[least] else s[least])
    return np.array(found)


def _row(place: float, computed_at: float, middle: float, envelope: SafeEnvelope) -> dict[str, Any]:
    (port, starboard), tops = envelope.walls, envelope.limited_by()
    return {
        "distance": place, "computed_at": computed_at, "port_bank": middle - port, "starboard_bank": middle + starboard,
        **_reach(envelope, envelope.safe(), middle), **_reach(envelope, envelope.by_model(), middle, "_by_model"),
        "limited_by": tops[len(tops) // 2],
    }  # fmt: skip


def _reach(envelope: SafeEnvelope, safe: xr.DataArray, middle: float, suffix: str = "") -> dict[str, float]:
    """Range of safe speeds that reaches highest [knots], and the widest run of safe offsets [m] with its speed."""
    table, u = safe.transpose("y", "u").to_numpy(), safe["u"].to_numpy() / KNOT
    speeds = [(float(u[run[1]]), float(u[run[0]])) for row in table for run in runs(row)[:1]]
    highest, lowest = max(speeds, default=(math.nan, math.nan))
    data, wide = envelope.data.transpose("y", "u", ...), []
    for column, speed in enumerate(u):
        for first, last in runs(table[:, column]):
            block = slice(first, last + 1), slice(column, column + 1)
            ends = safe_offsets(data, block, settings.SURE_SHARE)
            wide.append((ends[1] - ends[0], speed, *ends))
    _, speed, port, starboard = max(wide, default=(math.nan,) * 4)
    return {
        f"lowest_speed{suffix}": lowest, f"highest_speed{suffix}": highest, f"port{suffix}": float(port) + middle,
        f"starboard{suffix}": float(starboard) + middle, f"at_speed{suffix}": float(speed),
    }  # fmt: skip


def _ends(speeds: Any) -> str:
    """Return the lowest and the highest of a series of speeds by distance, in words."""
    places = dict.fromkeys((speeds.idxmin(), speeds.idxmax())) if len(speeds) else ()
    words = [f"{speeds[place]:.1f} knots at {place:.0f} m" for place in places]
    return f" (to {' and '.join(words)})" if words else ""


class Reach(NamedTuple):
    model: Model  # The model in the canal of that section
    middle: float  # Middle of that section, to starboard of the line [m]
    asked: dict[str, Any]  # Options of ``safe_envelope`` other than offsets and speeds


def reach_at(model: Model, waterway: "Waterway", at: float) -> Reach:
    """Return a place of a waterway; its curvature is that of the middle of the section."""
    ship = model.configuration.ship
    waterway.check_fits(ship, at)
    check_along_only(waterway, "an envelope")
    section, canal, room = waterway.section(at), waterway.canal(at), waterway.section(at, ship.draft)
    canal = canal if canal.depth else replace(canal, depth=model.configuration.canal.depth)
    middle, bend = float(section.middle), float(section.curvature)
    aside, half = float(room.middle) - middle, float(room.width) / 2
    there = replace(model, configuration=replace(model.configuration, canal=canal))
    asked = {
        "walls": (half - aside, half + aside), "curvature": bend / (1 - bend * middle),
        "current": float(waterway.current_at(at)),
    }  # fmt: skip
    return Reach(there, middle, asked)
