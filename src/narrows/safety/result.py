"""The safe envelope as a result: speeds by offset, offsets by speed, their limits, and the assumptions in words."""

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.base.errors import InputError, shown
from narrows.base.results import BaseResult
from narrows.model.data_range import MEASURES, DataRange, Measure, extrapolation, unknown_ranges
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.safety.channel_rules import OutsideRules, outside_rules
from narrows.safety.headline import RANGE, cause, headline, runs, safe_by
from narrows.safety.pilots import PILOTS
from narrows.safety.request import EnvelopeRequest, Keel
from narrows.safety.settings import SHIP_LENGTH, SURE_SHARE

if TYPE_CHECKING:
    import pandas as pd

# Shares of the cases: the median, and the 95 % that make a place safe.
MEDIAN = 0.5


def _attribute(name: str, meaning: str) -> Any:
    """Return a property that reads an attribute of the data."""
    return property(lambda envelope: envelope.data.attrs.get(name, ""), doc=meaning)


class SpeedsByOffset(xr.DataArray):  # type: ignore[misc]
    """Speeds that are also called with an offset, for the one interpolated there."""

    __slots__ = ()

    def __call__(self, y: float | None = None) -> xr.DataArray:
        return self if y is None else self.interp(y=y)


@dataclass(frozen=True, repr=False)
class SafeEnvelope(BaseResult):
    """The safe area of a ship, with its assumptions."""

    #: Over y [m] and u [m/s], the rudder [rad] of the steady course: ``rudder``, the median of the samples;
    #: ``rudder_low`` and ``rudder_high``, the central 90 %; ``rudder_95``, the size that 95 % do not exceed, infinite
    #: if more than 5 % have no course; ``rudder_likely``, with the most likely coefficients. Shares of the samples:
    #: ``found``, with a steady course; ``holds``, whose course leaves the reserve; ``held``, held by the pilot for the
    #: best estimate; ``known``, held by that pilot or by one with the true coefficients. ``held_low`` and
    #: ``held_high``: the 95 % interval for the number of samples. ``certain``: share of the disturbances in which a
    #: pilot with the true coefficients holds the most likely ship. ``tested``: True if the tests covered it. Over u:
    #: ``clearance`` [m] under the keel, and ``clear``, True if keel and canal allow the speed. Its attributes
    #: are the assumptions, and numbers of ship, canal, tests and rules [SI].
    data: xr.Dataset

    def __repr__(self) -> str:
        return f"<SafeEnvelope of {self.description}>"

    def dataset(self) -> xr.Dataset:
        """Return the result over offsets and speeds, with units."""
        return self.data

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the result as a table: one row per offset, with rudder [deg], speeds [knots] and limits."""
        import pandas as pd

        return pd.DataFrame(self.offset_rows()).set_index("offset")

    def to_dict(self) -> dict[str, Any]:
        return {
            "summary": self.summary(), "setting": self.description, "weather": self.weather, "pilot": self.pilot,
            "untested": self.untested, "samples": self.samples, "offsets": self.offset_rows(),
            "speeds": self.speed_rows(), "rules": self.rules.rows(), "notes": list(self.notes),
        }  # fmt: skip

    description = _attribute("setting", "Ship and canal in words.")
    weather = _attribute("weather", "Disturbances in words.")
    untested = _attribute("untested", "Reasons why the result is extrapolated; empty if it is not.")
    trust = _attribute("trust", "Uncertainties that the result leaves out, in sentences; empty if there are none.")
    pilot = _attribute("pilot_words", "The pilot in words.")

    @property
    def samples(self) -> int:
        """Number of cases at each offset and speed."""
        return int(self.data.attrs["samples"])

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumptions and limits of the result."""
        return tuple(str(self.data.attrs["notes"]).splitlines())

    @property
    def walls(self) -> tuple[float, float]:
        """Positions where the keel meets the banks [m], to port and to starboard of the middle."""
        return float(self.data.attrs["wall_port"]), float(self.data.attrs["wall_starboard"])

    @property
    def rules(self) -> OutsideRules:
        """Limits from design and canal rules for the same ship in the same section."""
        return OutsideRules(**{field.name: self.data.attrs[field.name] for field in fields(OutsideRules)})

    def by_model(self) -> xr.DataArray:
        """Return where it is safe by the model, tested or not: keel clear, and 95 % of the samples held."""
        return (self.data["held"] >= SURE_SHARE) & self.data["clear"]

    def safe(self, share: float = SURE_SHARE) -> xr.DataArray:
        """Return where it is safe, (y, u): by the model, within the tested range, and in a tested section.

        ``share`` is the least share of the samples [1]; an InputError if it is not from 0 to 1.
        """
        if not 0 <= share <= 1:
            raise InputError(f"share = {shown(share)} is no share from 0 to 1; safe() has all offsets and speeds")
        return (self.data["held"] >= share) & self.data["clear"] & self._covered

    @property
    def _covered(self) -> xr.DataArray:
        return self.data["tested"] & (not self.untested)

    def highest_speed(self, y: float | None = None) -> xr.DataArray:
        """Return the highest safe speed at each offset [m/s], NaN if there is none.

        It is the top of the lowest range of safe speeds, without gaps; with ``y`` [m] that of one offset, interpolated.
        """
        speeds = self._speeds(self.safe(), 1)
        return speeds if y is None else speeds.interp(y=y)

    @property
    def max_speed(self) -> "SpeedsByOffset":
        """The highest safe speed at each offset [m/s], also as ``max_speed(y=40)``: see ``highest_speed``."""
        return SpeedsByOffset(self.highest_speed())

    def largest_offset(self, u: float | None = None) -> xr.DataArray:
        """Return the largest offset safe to both sides at each speed [m], NaN if there is none; or at ``u`` [m/s]."""
        safe, y, size = self.safe(), self.data["y"], abs(self.data["y"])
        nearest = size.where(~safe).min("y").fillna(np.inf)
        # Farther off than the offsets of the other side nothing is known of both.
        known = size <= min(y.max(), -y.min()) * (1 + 1e-9)
        offsets = size.where(safe & known & (size < nearest)).max("y").assign_attrs(units="m")
        return offsets if u is None else offsets.interp(u=u)

    def lowest_speed(self) -> xr.DataArray:
        """Return the lowest safe speed at each offset [m/s], NaN if there is none: below it gusts may win."""
        return self._speeds(self.safe(), 0)

    def limited_by(self) -> list[str]:
        """Return the limit of the safe speeds at each offset."""
        limit, found = (1 - self.data.attrs["reserve"]) * self.data.attrs["rudder_limit"], []
        for index, ends in enumerate(_ends(self.safe())):
            above = 0 if ends is None else ends[1] + 1
            fastest = above == self.data.sizes["u"]
            found.append(RANGE if fastest else cause(self.data.isel(y=index, u=above), SURE_SHARE, limit))
        return found

    def summary(self) -> str:
        return " ".join(filter(None, (self.answer, *self.limits, self.trust)))

    @cached_property
    def _headline(self) -> tuple[list[str], list[str]]:
        return headline(self.data, SURE_SHARE)

    @property
    def answer(self) -> str:
        """Where it is safe, in one or two sentences."""
        return " ".join(self._headline[0])

    @property
    def limits(self) -> tuple[str, ...]:
        """Limits of the safe range, in sentences."""
        return tuple(self._headline[1])

    def offset_rows(self) -> list[dict[str, Any]]:
        """Return one row per offset: rudder [deg], range of safe speeds [knots], and their limits.

        The rudder is that at the highest safe speed, or the highest likely one, or else the lowest.
        """
        top, bottom, likely = self.highest_speed(), self.lowest_speed(), self._speeds(self.safe(MEDIAN), 1)
        at = top.fillna(likely).fillna(self.data["u"][0])
        here, by_true = self.data.sel(u=at), (self.data["known"] >= SURE_SHARE) & self.data["clear"]
        columns = {
            "offset": here["y"], "rudder": np.degrees(here["rudder"]), "rudder_95": np.degrees(here["rudder_95"]),
            "held": here["held"], "known": here["known"], "lowest_speed": bottom / KNOT, "highest_speed": top / KNOT,
            "highest_speed_known": self._speeds(by_true & self._covered, 1) / KNOT,
            "highest_speed_median": likely / KNOT,
        }  # fmt: skip
        return _rows(columns | {"limited_by": self.limited_by()})

    def speed_rows(self) -> list[dict[str, Any]]:
        """Return one row per speed [knots]: keel clearance [m], and whether keel and canal allow the speed."""
        columns = {"keel_clearance": self.data["clearance"], "keel_clear": self.data["clear"]}
        return _rows({"speed": self.data["u"] / KNOT, **columns})

    def _speeds(self, safe: xr.DataArray, end: int) -> xr.DataArray:
        speeds = self.data["u"].to_numpy()
        ends_of = [math.nan if ends is None else float(speeds[ends[end]]) for ends in _ends(safe)]
        return xr.DataArray(ends_of, coords={"y": self.data["y"]}, dims="y", attrs={"units": "m/s"})


def _ends(safe: xr.DataArray) -> list[tuple[int, int] | None]:
    return [next(iter(runs(row)), None) for row in safe.transpose("y", "u").to_numpy()]


def _rows(columns: dict[str, Any]) -> list[dict[str, Any]]:
    lists = (np.asarray(column).tolist() for column in columns.values())
    return [dict(zip(columns, row, strict=True)) for row in zip(*lists, strict=True)]


def noting(envelope: SafeEnvelope, *notes: str) -> SafeEnvelope:
    """Return the result with further first notes, each in one line."""
    return SafeEnvelope(envelope.data.assign_attrs(notes="\n".join((*notes, *envelope.notes))))


def with_caveats(data: xr.Dataset, request: EnvelopeRequest, under: Keel, samples: int) -> SafeEnvelope:
    model, configuration = request.model, request.model.configuration
    rules = outside_rules(configuration, request.bank, request.walls)
    words = (configuration.ship.in_words, configuration.canal.in_words, request.bend.words)
    notes = envelope_notes(request, under)
    # [m/s] and [m], if the tests give them.
    ranges = {"tested_speed": model.data_range.speed, "tested_offset": model.data_range.abs_y}
    rests_on = {
        "setting": ", in ".join(filter(None, words)),
        "weather": request.disturbance.words,
        "notes": "\n".join((*notes, *exceeded_rules(data, rules, SURE_SHARE))),
        "rudder_limit": configuration.gear.limit,
        "reserve": request.reserve,
        "pilot": request.pilot,
        "pilot_words": PILOTS[request.pilot].words,
        "samples": samples,
        "untested": untested_reasons(model),
        "trust": left_out(model),
        "estimate": model.source.estimate,
        **{name: list(covered) for name, covered in ranges.items() if covered is not None},
        **vars(rules),
    }
    return SafeEnvelope(data.assign_attrs(rests_on))


def envelope_notes(request: EnvelopeRequest, under: Keel) -> list[str]:
    model, configuration, gear = request.model, request.model.configuration, request.model.configuration.gear
    notes = [*model.notes, *beyond_tests(model, request.offsets, request.speeds), *under.notes]
    if model.covariance is None:
        notes.append("the model has no covariance: the samples vary disturbances alone")
    if configuration.canal.depth is not None:
        notes.append(f"{request.clearance:.2g} m are to be left under the keel")
    notes.append(f"one pilot for all cases: {PILOTS[request.pilot].words}")
    notes.append(f"rudder to {gear.limit_deg:.3g} degrees at {gear.rate_deg:.3g} degrees a second")
    if configuration.steering is None and configuration.ship.length < SHIP_LENGTH:
        notes.append(
            "the default rudder rate is that of a full-size ship; scale the model, or give [steering] its rate"
        )
    if not model.terms.propelled:
        return [*notes, "the speed is constant: the propeller's limit is ignored"]
    engine = "give speeds that the engine reaches"
    return [*notes, f"the propeller keeps the revolutions of straight ahead, and the speed follows; {engine}"]


def exceeded_rules(data: xr.Dataset, rules: OutsideRules, share: float) -> list[str]:
    """Return a sentence on the rules that the envelope exceeds in width, rudder or speed, with the reason."""
    data, safe = data.transpose("y", "u", ...), safe_by(data, share)
    if not safe.any():
        return []
    y, knots, exceeded = data["y"].to_numpy(), data["u"].to_numpy() / KNOT, dict[str, None]()
    rudder = float(np.degrees(np.abs(data["rudder"].to_numpy()[safe]).max()))  # The median of the samples
    fastest = float(knots[safe.any(axis=0)].max())
    for row in rules.rows():
        if row["width"] is None:
            over = rudder > (row["rudder"] or np.inf) or fastest > (row["speed_limit"] or np.inf)
        else:
            far = y[safe[:, (knots >= row["slowest"]) & (knots <= (row["fastest"] or np.inf))].any(axis=1)]
            fits = row["starboard"] is not None
            over = far.size > 0 and not (fits and row["port"] <= far.min() and far.max() <= row["starboard"])
        exceeded |= {row["rule"]: None} if over else {}
    reasons = (
        "widths of rules include manual steering, wind and current, but the pilot of these trials has exact offset, "
        "heading and drift; rules keep the rudder small, the trials keep a reserve of it; speed limits also protect "
        "banks and traffic"
    )
    return [f"The envelope exceeds {', '.join(exceeded)}: {reasons}."] if exceeded else []


# Parts of an envelope inside the tested range. Wording of ranges for the bridge.
IN_KNOTS = {**MEASURES, "speed": Measure("speed", "knots", 1 / KNOT)}
SPOKEN = {"speed": "speed", "abs_y": "offset", "depth_to_draft": "h/T", "width_to_beam": "W/B"}


def data_coverage(model: Model, offsets: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Return which offsets and speeds the tests covered, (offsets, speeds); none in a section that is not known."""
    # offsets (n,) [m]; speeds (m,) [m/s]. A place nearer to the middle than the tests counts as covered.
    known = _to_the_middle(model)
    near, fast = known.outside("abs_y", np.abs(offsets)), known.outside("speed", speeds)
    given = known.abs_y and known.speed and known.width_to_beam and known.depth_to_draft
    section = model.has_bank and model.configuration.canal.depth and given
    return np.asarray(bool(section) & ~np.asarray(near)[:, None] & ~np.asarray(fast)[None])


def _to_the_middle(model: Model) -> DataRange:
    known = model.data_range
    return replace(known, abs_y=known.abs_y and (0.0, known.abs_y[1]))


def beyond_tests(model: Model, offsets: np.ndarray, speeds: np.ndarray) -> tuple[str, ...]:
    # offsets (n,) [m]; speeds (m,) [m/s]
    asked = {"speed": speeds, "abs_y": np.abs(offsets).max(), **_section(model)}
    return extrapolation(_to_the_middle(model), asked, IN_KNOTS)


def untested_reasons(model: Model) -> str:
    """Return the reasons why the result is extrapolated: no bank, unknown ranges, an untested section."""
    known, words = model.data_range, []
    if not model.has_bank:
        words.append("this model has no bank term (fit tests near a bank with --terms paper, or take one that has)")
    unknown = unknown_ranges(known, ("speed", "abs_y", *_section(model)))
    if unknown:
        words.append(f"the file does not give the tested ranges of {', '.join(SPOKEN[name] for name in unknown)}")
    if model.configuration.canal.depth is None:
        words.append("the depth of the canal is not known")
    there = [
        f"{(of := IN_KNOTS[name]).words} {of.describe(value, value)} ({of.describe(*getattr(known, name))} was tested)"
        for name, value in _section(model).items()
        if known.outside(name, value)
    ]
    return " and ".join((*words, *there))


def left_out(model: Model) -> str:
    """Return, in sentences, uncertainties that the result does not include."""
    # The first sentence names an estimated model as one, without tests.
    lines = ["" if model.source.estimate else model.trust_note, model.unknown_note]
    if model.covariance is None:
        lines.append("The uncertainty of the coefficients is not known, so it is not counted.")
    if model.configuration.canal.depth is None:
        lines.append("The depth of the canal is not known, so squat and grounding of the keel are not counted.")
    return " ".join(filter(None, lines))


def _section(model: Model) -> dict[str, float]:
    ship, canal = model.configuration.ship, model.configuration.canal
    depth = {} if canal.depth is None else {"depth_to_draft": canal.depth / ship.draft}
    return {**depth, "width_to_beam": canal.width / ship.beam}
