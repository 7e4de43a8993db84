"""Assumptions and limits of a safe envelope: attributes that accompany its data into file and chart."""

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from narrows.model.data_range import MEASURES, DataRange, Measure, extrapolation
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.safety.channel_rules import READ, OutsideRules, outside_rules
from narrows.safety.headline import safe_by
from narrows.safety.pilots import PILOTS
from narrows.safety.request import EnvelopeRequest, Keel
from narrows.safety.result import SafeEnvelope
from narrows.safety.settings import SHIP_LENGTH, SURE_SHARE

SQUARED = (
    "every force of these terms is proportional to the square of the speed, so the steady rudder is the same at any "
    "speed: except for squat and choking, nothing makes a fast ship harder to hold"
)


def with_caveats(found: SafeEnvelope, request: EnvelopeRequest, under: Keel, samples: int) -> SafeEnvelope:
    model, configuration = request.model, request.model.configuration
    rules = outside_rules(configuration, request.bank, request.walls)
    notes = (
        *envelope_notes(request, under),
        *((SQUARED,) if found.speed_free else ()),
        *exceeded_rules(found.data, rules, SURE_SHARE),
    )
    # [m/s] and [m], if the tests give them.
    ranges = {"tested_speed": model.data_range.speed, "tested_offset": model.data_range.abs_y}
    rests_on = {
        "setting": ", in ".join(
            filter(None, (configuration.ship.in_words, configuration.canal.in_words, request.bend.words))
        ),
        "weather": request.disturbance.words,
        "notes": "\n".join(notes),
        "beam": configuration.ship.beam,
        "wall_port": request.walls[0],
        "wall_starboard": request.walls[1],
        "rudder_limit": configuration.gear.limit,
        "reserve": request.reserve,
        "pilot": request.pilot,
        "pilot_words": PILOTS[request.pilot].words,
        "samples": samples,
        "untested": untested_reasons(model),
        "trust": left_out(model),
        "estimate": model.source.estimate,
        **{name: list(covered) for name, covered in ranges.items() if covered is not None},
        **rules.attributes(),
    }
    return SafeEnvelope(found.data.assign_attrs(rests_on))


def envelope_notes(request: EnvelopeRequest, under: Keel) -> tuple[str, ...]:
    model, configuration = request.model, request.model.configuration
    notes = [*model.notes, *beyond_tests(model, request.offsets, request.speeds), *under.notes]
    if model.covariance is None:
        notes.append("the model has no covariance: the samples vary disturbances alone")
    if configuration.canal.depth is not None:
        notes.append(f"{request.clearance:.2g} m are to be left under the keel")
    notes.append(f"one pilot for all cases: {PILOTS[request.pilot].words}")
    gear = configuration.gear
    notes.append(f"rudder to {gear.limit_deg:.3g} degrees at {gear.rate_deg:.3g} degrees a second")
    if configuration.steering is None and configuration.ship.length < SHIP_LENGTH:
        notes.append(
            "the default rudder rate is that of a full-size ship; scale the model, or give the rate in [steering]"
        )
    return (*notes, _propulsion(model, request.most_revolutions))


def _propulsion(model: Model, most: float | None) -> str:
    if not model.terms.propelled:
        return "the speed is constant: the propeller's limit is ignored"
    turning = "the propeller keeps the revolutions of straight ahead, and the speed follows"
    if most is None:
        return f"{turning}; without a limit of the engine: give its most revolutions"
    return f"{turning}; the engine makes up to {most:g} revolutions a second"


# Cases in which the model allows more than an outside rule, and the reason.
WHY_WIDER = (
    "those widths include manual steering, wind and current; the pilot of these trials has exact offset, heading and "
    "drift, and only the weather above"
)

WHY_RUDDER = "here the steady rudder leaves a reserve, which the trials test, instead of staying small"
WHY_FASTER = "those limits also protect banks and traffic, which is not examined here"


def exceeded_rules(data: xr.Dataset, rules: OutsideRules, share: float) -> tuple[str, ...]:
    """Return up to three sentences: the exceeded rules on widths, on rudder angles and on speeds, with the reason."""
    data, safe = data.transpose("y", "u", ...), safe_by(data, share)
    if not safe.any():
        return ()
    rows = rules.rows()
    return tuple(filter(None, (_wider(data, safe, rows), _harder(data, safe, rows), _faster(data, safe, rows))))


def _wider(data: xr.Dataset, safe: np.ndarray, rows: list[dict[str, Any]]) -> str:
    """Describe the exceeded rules on widths, each at the speed of the largest excess."""
    y, knots = data["y"].to_numpy(), data["u"].to_numpy() / KNOT
    worst: dict[str, tuple[float, str]] = {}
    for row in rows:
        if row["width"] is None:
            continue
        asked = (knots >= row["slowest"]) & (knots <= (row["fastest"] or np.inf))
        far = y[safe[:, asked].any(axis=1)]
        fits = row["starboard"] is not None
        limits = (row["port"], row["starboard"]) if fits else (0.0, 0.0)
        over = max((limits[0] - far.min(), far.max() - limits[1])) if far.size else -1.0
        if far.size and (over > 0 or not fits):
            place = float(far[np.abs(far).argmax()])
            allowed = f"{limits[1] if place > 0 else limits[0]:+.0f} m" if fits else "nowhere"
            doubt = "" if row["standing"] == READ else ", in part from memory"
            words = f"{row['rule']} ({allowed} instead of {place:+.0f} m{doubt})"
            worst[row["rule"]] = max(worst.get(row["rule"], (-np.inf, "")), (over, words))
    listed = " and ".join(words for _, words in worst.values())
    return f"The envelope is wider than {listed}: {WHY_WIDER}." if worst else ""


def _harder(data: xr.Dataset, safe: np.ndarray, rows: list[dict[str, Any]]) -> str:
    """Describe the exceeded rules on rudder angles, by the median rudder of the safe cases."""
    most = float(np.degrees(np.abs(data["rudder"].to_numpy()[safe]).max()))
    rules = [row for row in rows if row["rudder"] is not None and most > row["rudder"]]
    listed = " and ".join(f"{row['rule']} ({row['rudder']:g} instead of {most:.0f} degrees)" for row in rules)
    return f"The envelope needs more rudder than {listed}: {WHY_RUDDER}." if rules else ""


def _faster(data: xr.Dataset, safe: np.ndarray, rows: list[dict[str, Any]]) -> str:
    """The exceeded speed limits."""
    fastest = float(data["u"].to_numpy()[safe.any(axis=0)].max()) / KNOT
    over = [row for row in rows if row["speed_limit"] is not None and fastest > row["speed_limit"]]
    listed = ", ".join(f"{row['rule']} ({row['speed_limit']:.1f} knots)" for row in over)
    return f"The model is safe up to {fastest:.1f} knots, above the limits of {listed}: {WHY_FASTER}." if over else ""


# Parts of an envelope inside the tested range. Wording of ranges for the bridge.
IN_KNOTS = {**MEASURES, "speed": Measure("speed", "knots", 1 / KNOT)}
SPOKEN = {"speed": "speed", "abs_y": "offset", "depth_to_draft": "h/T", "width_to_beam": "W/B"}
NO_BANK = "this model has no bank term (fit tests near a bank with --terms paper, or take a model that has one)"
UNKNOWN = "the file does not give the tested ranges of"


def data_coverage(model: Model, offsets: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Return which offsets and speeds the tests covered, (offsets, speeds); none in a section that is not known."""
    # offsets (n,) [m]; speeds (m,) [m/s]. A place nearer to the middle than the tests counts as covered.
    known = _to_the_middle(model)
    near, fast = known.covers("abs_y", np.abs(offsets)), known.covers("speed", speeds)
    section = model.configuration.canal.depth and known.width_to_beam and known.depth_to_draft
    return np.asarray(bool(model.has_bank and section) & np.asarray(near)[:, None] & np.asarray(fast)[None])


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
        words.append(NO_BANK)
    unknown = known.unknown(("speed", "abs_y", *_section(model)))
    if unknown:
        words.append(f"{UNKNOWN} {', '.join(SPOKEN[name] for name in unknown)}")
    if model.configuration.canal.depth is None:
        words.append("the depth of the canal is not known")
    there = [
        f"{IN_KNOTS[name].words} {IN_KNOTS[name].shown(value, value)} ({IN_KNOTS[name].shown(*getattr(known, name))} "
        "was tested)"
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
