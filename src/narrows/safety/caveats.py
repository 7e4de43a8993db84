"""What a safe envelope rests on and leaves out: the attributes that travel with its data into file and chart."""

from narrows.model.model import Model
from narrows.safety.answer import SURE_SHARE, SafeEnvelope
from narrows.safety.bolder import bolder_than
from narrows.safety.outside_rules import outside_rules
from narrows.safety.pilots import PILOTS
from narrows.safety.question import EnvelopeQuestion
from narrows.safety.tested import beyond_tests, tested_ranges, untested_section
from narrows.safety.underkeel import Keel

# Below this [m] a hull is taken for a model's.
SHIP_LENGTH = 30.0
SQUARED = (
    "every force of these terms goes with the square of the speed, so the rudder that holds the ship is the same at "
    "any: what makes a fast ship harder to hold, beside squat and choking, is not in them"
)


def with_caveats(found: SafeEnvelope, question: EnvelopeQuestion, under: Keel, samples: int) -> SafeEnvelope:
    """Return an answer with all that it rests on as its attributes."""
    model, configuration = question.model, question.model.configuration
    rules = outside_rules(configuration, question.bank, question.walls)
    notes = (
        *envelope_notes(question, under),
        *((SQUARED,) if found.speed_free else ()),
        *bolder_than(found.data, rules, SURE_SHARE),
    )
    rests_on = {
        "setting": f"{configuration.ship.in_words}, in {configuration.canal.in_words}",
        "weather": question.disturbance.words,
        "notes": "\n".join(notes),
        "beam": configuration.ship.beam,
        "wall_port": question.walls[0],
        "wall_starboard": question.walls[1],
        "rudder_limit": configuration.gear.limit,
        "reserve": question.reserve,
        "pilot": question.pilot,
        "pilot_words": PILOTS[question.pilot].words,
        "samples": samples,
        "untested": untested_section(model),
        "trust": model.trust_note,
        **tested_ranges(model),
        **rules.attributes(),
    }
    return SafeEnvelope(found.data.assign_attrs(rests_on))


def envelope_notes(question: EnvelopeQuestion, under: Keel) -> tuple[str, ...]:
    """Say what the answer to a question rests on, and what it leaves out, a sentence each."""
    model, configuration = question.model, question.model.configuration
    notes = [*model.bank_notes, *beyond_tests(model, question.offsets, question.speeds), *under.notes]
    if model.covariance is None:
        notes.append("no covariance of the coefficients is known: the samples are of disturbances alone")
    if configuration.canal.depth is not None:
        notes.append(f"{question.clearance:.2g} m are to be left under the keel")
    notes.append(f"one pilot for all cases: {PILOTS[question.pilot].words}")
    gear = configuration.gear
    notes.append(f"rudder to {gear.limit_deg:.3g} degrees at {gear.rate_deg:.3g} degrees a second")
    if configuration.steering is None and configuration.ship.length < SHIP_LENGTH:
        notes.append("that gear is a ship's, and this is a model's size: scale the model, or give [steering] its rate")
    return (*notes, _propulsion(model, question.most_revolutions))


def _propulsion(model: Model, most: float | None) -> str:
    if not model.terms.propelled:
        return "the speed is held: what the propeller can give is not asked"
    turning = "the propeller turns as the speed asks straight ahead"
    if most is None:
        return f"the speed is held: {turning}, however fast that is; give the engine's most revolutions to bound it"
    return f"the speed is held: {turning}, up to {most:g} revolutions a second"
