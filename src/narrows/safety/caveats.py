"""Assumptions and limits of a safe envelope: attributes that accompany its data into file and chart."""

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from narrows.model.data_range import MEASURES, DataRange, Measure, extrapolation, unknown_ranges
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.safety.channel_rules import READ, OutsideRules, outside_rules
from narrows.safety.headline import safe_by
from narrows.safety.pilots import PILOTS
from narrows.safety.request import EnvelopeRequest, Keel
from narrows.safety.result import SafeEnvelope
from narrows.safety.settings import SHIP_LENGTH, SURE_SHARE


def with_caveats(data: xr.Dataset, request: EnvelopeRequest, under: Keel, samples: int) -> SafeEnvelope:
    model, configuration = request.model, request.model.configuration
    rules = outside_rules(configuration, request.bank, request.walls)
    words = (configuration.ship.in_words, configuration.canal.in_words, request.bend.words)
    notes = envelope_notes(request, under)
    if SafeEnvelope(data).speed_free:
        notes.append(
            "every force of these terms is proportional to the square of the speed, so the steady rudder is the same "
            "at any speed: except for squat and choking, nothing makes a fast ship harder to hold"
        )
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
            "the default rudder rate is that of a full-size ship; scale the model, or give the rate in [steering]"
        )
    if not model.terms.propelled:
        return [*notes, "the speed is constant: the propeller's limit is ignored"]
    engine = "without a limit of the engine: give its most revolutions"
    if request.most_revolutions is not None:
        engine = f"the engine makes up to {request.most_revolutions:g} revolutions a second"
    return [*notes, f"the propeller keeps the revolutions of straight ahead, and the speed follows; {engine}"]


def exceeded_rules(data: xr.Dataset, rules: OutsideRules, share: float) -> list[str]:
    """Return a sentence each on exceeded rules of widths, of rudder angles and of speeds, with the reason."""
    data, safe = data.transpose("y", "u", ...), safe_by(data, share)
    if not safe.any():
        return []
    y, knots = data["y"].to_numpy(), data["u"].to_numpy() / KNOT
    rudder = float(np.degrees(np.abs(data["rudder"].to_numpy()[safe]).max()))  # The median of the samples
    fastest = float(knots[safe.any(axis=0)].max())
    wider: dict[str, tuple[float, str]] = {}  # The largest excess of each rule, in metres and in words
    harder, faster = [], []
    for row in rules.rows():
        rule = row["rule"]
        if row["width"] is not None:
            far = y[safe[:, (knots >= row["slowest"]) & (knots <= (row["fastest"] or np.inf))].any(axis=1)]
            wider[rule] = max(wider.get(rule, (0.0, "")), _excess(row, far))
        elif row["rudder"] is not None and rudder > row["rudder"]:
            harder.append(f"{rule} ({row['rudder']:g} instead of {rudder:.0f} degrees)")
        elif row["speed_limit"] is not None and fastest > row["speed_limit"]:
            faster.append(f"{rule} ({row['speed_limit']:.1f} knots)")
    widths = " and ".join(words for _, words in wider.values() if words)
    sentences = {
        f"The envelope is wider than {widths}: those widths include manual steering, wind and current; the pilot of "
        "these trials has exact offset, heading and drift, and only the weather above.": widths,
        f"The envelope needs more rudder than {' and '.join(harder)}: here the steady rudder leaves a reserve, which "
        "the trials test, instead of staying small.": harder,
        f"The model is safe up to {fastest:.1f} knots, above the limits of {', '.join(faster)}: those limits also "
        "protect banks and traffic, which is not examined here.": faster,
    }
    return [sentence for sentence, exceeded in sentences.items() if exceeded]


def _excess(row: dict[str, Any], far: np.ndarray) -> tuple[float, str]:
    """Return by how much safe offsets exceed a rule [m], and both limits in words; 0 and no words if they do not."""
    fits = row["starboard"] is not None
    port, starboard = (row["port"], row["starboard"]) if fits else (0.0, 0.0)
    if not far.size or (fits and far.min() >= port and far.max() <= starboard):
        return 0.0, ""
    place = float(far[np.abs(far).argmax()])
    allowed = f"{starboard if place > 0 else port:+.0f} m" if fits else "nowhere"
    doubt = "" if row["standing"] == READ else ", in part from memory"
    return max(port - far.min(), far.max() - starboard), f"{row['rule']} ({allowed} instead of {place:+.0f} m{doubt})"


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
        words.append(
            "this model has no bank term (fit tests near a bank with --terms paper, or take a model that has one)"
        )
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
