"""Initial conditions of a voyage: inputs of its integrator, defaults, revolutions; errors of an impossible start."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean
from narrows.codegen.kernels import event
from narrows.model.model import Model
from narrows.model.water import choke_speed
from narrows.quantities.names import GRAVITY
from narrows.ship.actuators import PROPELLER, places_of
from narrows.ship.motion import Motion
from narrows.simulation import settings
from narrows.simulation.controllers import Controller
from narrows.simulation.inputs import INPUTS as PUSHED
from narrows.simulation.inputs import START
from narrows.simulation.integrator import VoyageIntegrator
from narrows.simulation.kernel_run import PUSH_END, KernelRun
from narrows.simulation.ship import SimulatedShip, Steering

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


POSE = ("x", "y", "psi", "u", "v", "r")


def check_positions(positions: Mapping[str, float], ship: SimulatedShip) -> None:
    known = [actuator.name for actuator in ship.actuators]
    for name in positions:
        if name not in known:
            stem = name.removesuffix("_deg")
            in_degrees = stem != name and stem in {*POSE, *known, "rudder"}
            if in_degrees:
                raise InputError(f"there is no argument {name!r}; write {stem}=np.radians(...)")
            hint = did_you_mean(name, known) if known else "; it has none"
            raise InputError(f"there is no argument {name!r}, and no actuator of the model has this name{hint}")


def initial_state(
    ship: SimulatedShip, steering: Steering | None, numbers: dict[str, float], waterway: "Waterway | None", pushed: bool
) -> tuple[VoyageIntegrator, tuple[float, ...]]:
    """Return the integrator with every input of its lines, and its initial state."""
    if waterway is not None and not 0 <= (x := numbers["x"]) < waterway.line.length:
        raise InputError(f"x = {x:g} m is not on {waterway.name}, 0 to {waterway.line.length:.0f} m; start on it")
    run = KernelRun(ship, math.inf, math.inf, steering, waterway)
    values = {**dict.fromkeys(PUSHED, 0.0), **numbers, **({PUSH_END: math.inf} if pushed else {})}
    system = run.system(values)
    inputs, channel = run.inputs(system, values)
    order = steering.asked if steering else None
    order = order.begin() if isinstance(order, Controller) else order
    near = settings.NEAR_THE_BANK * float(inputs["width"])
    integrator = VoyageIntegrator(system, inputs, channel, near, order)
    state = run.start(values)
    start = tuple(float(state[name]) for name in system.choices.kept)
    _check_start(integrator, start)
    return integrator, start


def _check_start(integrator: VoyageIntegrator, start: tuple[float, ...]) -> None:
    _, y, cosine, sine, *_ = start
    if cosine <= integrator.inputs["least_cos"]:
        heading = math.degrees(math.atan2(sine, cosine))
        raise InputError(f"psi = {heading:.1f} deg lies across the canal; start within 85 deg")
    clearance, _ = integrator.clearance(start)
    met = integrator.cause(event.CLOSED, start)
    if met == event.GROUNDED and (clearance < 0 or (clearance == 0 and start[0] != integrator.channel.start)):
        raise InputError(
            f"y = {y:g} m starts with the hull {-clearance:.3g} m into the bank; start nearer the centreline"
        )
    # A step of the smallest number instead of 0: 0 times an infinite rate would be NaN.
    if not all(map(math.isfinite, integrator.stepped(start, math.ulp(0.0))[0])):
        u, v, r = start[4:7]
        raise InputError(f"the forces of this model are not finite at u = {u:g}, v = {v:g}, r = {r:g}; start otherwise")


def check_irrelevant(ship: SimulatedShip, given: Mapping[str, Any]) -> None:
    """Raise if an argument has no effect."""
    terms = ship.model.terms
    relevant = {*START, *PUSHED, *terms.inputs, *terms.names, "length", "beam", "width", *places_of(terms.actuators)}
    relevant |= {actuator.name for actuator in terms.actuators}
    relevant |= {"mass", "inertia", "x_g"} if ship.coriolis else set()
    relevant |= {"depth", "draft", "block_coefficient"} if ship.bottom else set()
    relevant -= {"X"} if ship.surge == "held" else set()
    for name, value in given.items():
        is_zero = name in ("X", "rudder", "heave") and not np.any(value)
        if name not in relevant and not is_zero:
            remedy = "give surge='free', or leave it out" if name == "X" else "leave it out"
            why = "the speed is held" if name == "X" else "no term of this model depends on it"
            raise InputError(f"{name} changes nothing here: {why}; {remedy}")


class VoyageDefaults(NamedTuple):
    speed: float  # Within the tested range, and below choking [m/s]
    duration: float  # Longest time [s]
    dt: float  # Time step [s]
    offset: float  # Largest starting offset of a map [m]


def voyage_defaults(model: Model, speeds: Any = None) -> VoyageDefaults:
    """Return defaults for the ship of a model in its canal, at given speeds if any, each to two digits."""
    ship, canal = model.configuration.ship, model.configuration.canal
    given = np.abs(np.asarray([] if speeds is None else speeds, float))
    given = given[(given > 0) & (given < math.inf)]
    if not given.size:
        low, high = model.data_range.speed or (0.0, math.inf)
        most = settings.DEFAULT_SHARE_OF_CHOKING * choke_speed(model.configuration) if canal.depth else math.inf
        given = np.array([min(max(settings.DEFAULT_FROUDE * math.sqrt(GRAVITY * ship.length), low), high, most)])
    longest, step = (
        settings.DEFAULT_LENGTHS * ship.length / given.min(),
        ship.length / given.max() / settings.DEFAULT_STEPS_A_LENGTH,
    )
    offset = max(canal.width - ship.beam, 0.0) / 2 * settings.DEFAULT_OFFSET
    return VoyageDefaults(*(float(f"{value:.2g}") for value in (given.max(), longest, step, offset)))


@accept_aliases
def self_propulsion(model: Model, u: float) -> float:
    """Return the revolutions at which thrust balances resistance straight ahead, rudder amidships [1/s].

    Raises an InputError if the model has no propeller, or no revolutions reach the speed.

    Parameters
    ----------
    model : Model
        A model with terms of a propeller.
    u : float [m/s]
        Surge velocity.

    Examples
    --------
    >>> kvlcc2 = nw.published("yasukawa2015_kvlcc2")
    >>> round(float(nw.self_propulsion(kvlcc2, u=1.0)), 1)
    10.1
    """
    from scipy.optimize import brentq

    if not model.terms.propelled:
        raise InputError("this model has no terms of a propeller; there are no revolutions to look for")

    def surplus(revolutions: float) -> float:
        return -model.resistance(u, revolutions=revolutions)

    turns = 2.0 ** np.arange(-10, 20)
    fast = turns[np.asarray(model.forces(Motion.at(u=u), revolutions=turns)["X"]) > 0]
    if not len(fast):
        raise InputError(f"no revolutions drive this ship at {u:g} m/s; check the propeller and the resistance")
    return float(brentq(surplus, 0.0, float(fast[0]))) if surplus(0.0) < 0 else 0.0


def steady_ahead(model: Model, u: float) -> tuple[Model, str]:
    """Return the model with revolutions that keep the approach speed, and a note; itself if its own nearly do."""
    propeller, steady = model.configuration.propeller, steady_revolutions(model, u)
    if steady is None or propeller is None or not model.surge_inertia > 0:
        return model, ""
    configuration = replace(model.configuration, propeller=replace(propeller, revolutions=steady))
    own = f"the model's own, {propeller.revolutions:.3g}, are for another"
    note = f"{steady:.3g} revolutions a second keep the approach speed; {own}"
    return replace(model, configuration=configuration), note


def steady_revolutions(model: Model, u: float) -> float | None:
    own = model.configuration.propeller.revolutions if model.configuration.propeller else 0.0
    if not (model.terms.propelled and own > 0 and u > 0):
        return None
    least, most = (model.resistance(u, revolutions=own / (1 + side * settings.OWN_REVOLUTIONS)) for side in (1, -1))
    return None if least >= 0 >= most else self_propulsion(model, u)


def propeller_notes(model: Model, speeds: Any, turns: Any, steering: Steering | None) -> tuple[str, ...]:
    """Return a note if the model's own revolutions are for another speed [m/s]; none if others are given or ordered."""
    own = model.configuration.propeller
    ordered = steering is not None and any(one.name == PROPELLER.name for one in steering.law.ordered)
    if own is None or ordered or (turns is not None and np.any(np.asarray(turns) != own.revolutions)):
        return ()
    pairs = [(u, steady_revolutions(model, u)) for u in dict.fromkeys((float(np.min(speeds)), float(np.max(speeds))))]
    kept = [f"{steady:.3g} keep {u:.3g} m/s straight ahead" for u, steady in pairs if steady is not None]
    if not kept:
        return ()
    first = f"The propeller's {own.revolutions:.3g} revolutions a second are for another speed"
    return (f"{first}: {', '.join(kept)} (--revolutions, in Python revolutions=).",)
