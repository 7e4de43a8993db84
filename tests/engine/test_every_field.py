"""A differential test of what users build: changing a field of it changes an answer; nothing is ignored in silence."""

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
from arguments import by_depth, held_legs, shallow
from cases import mmg, paper, steered, waterway_for

import narrows as nw

MADE = {
    "BankForce", "CaptiveTests", "Comparison", "DepthCorrected",
    "Explanation", "Fit", "InformationForecast", "InputError",
    "Jacobian", "LogFit", "LogFindings", "Model", "Outcome", "OutsideRules", "Plan", "SafeEnvelope",
    "Scaled", "Sensitivities", "Squat", "SteadyFit", "SteadyPlan", "SteadyReadings", "StoppingTest", "Trials",
    "Turning", "Voyage", "Fleet", "ZigzagTest",
}  # fmt: skip
"""What functions return."""
VOCABULARY = {
    "BankForm",
    "DataRange",
    "Dimension",
    "Motion",
    "RunErrors",
    "Source",
    "SquatFormula",
    "Term",
    "TermKind",
    "TermTable",
}
"""What models, tables and formulas are written in, held elsewhere."""

FED = {"Monitor"}
"""What takes readings second by second, held in tests/warning/test_monitor.py."""

INTERFACES = {"ControlLaw", "Controller"}
"""What a control law of one's own keeps to."""


@dataclass(frozen=True)
class Built:
    """Something that users build, what it answers, and another value of each field."""

    usual: Any
    answer: Callable[[Any], Any]
    others: dict[str, Any]


def sailed(model: nw.Model, **told: Any) -> Any:
    voyage = nw.simulate(model, **{"y": 0.5, "duration": 6.0, "dt": 0.25, **told})
    return voyage.outcome.state, voyage.outcome.time


def with_parts(model: nw.Model, **parts: Any) -> nw.Model:
    return replace(model, configuration=replace(model.configuration, **parts))


def controlled(law: Any) -> Any:
    try:
        return sailed(steered(), controller=law)
    except TypeError:
        return sailed(steered(), helm=law)


def of_mmg(**parts: Any) -> Any:
    model, astern = with_parts(mmg(), **parts), {"revolutions": -3.0, "surge": "free"}
    motions = {"rudder": 0.2, "v": 0.05, "r": 0.02}, {"rudder": -0.2, "v": -0.05, "r": -0.02}, astern
    return tuple(sailed(model, **motion) for motion in motions)


def measured(run: Any) -> Any:
    tests = nw.twin(shallow(), runs=(run,), noise={}, rate=5.0)
    return tests.names, {name: column.tolist() for name, column in tests.columns.items()}


def planned(tank: nw.Tank) -> Any:
    plan = nw.plan_tests(shallow().configuration, 6, tank=tank, terms=shallow().terms, targets=("b_bank", "c_r"))
    return plan.rows(), plan.notes


def enveloped(disturbance: nw.Disturbance) -> Any:
    blown = nw.safe_envelope(by_depth(), np.array([0.6]), np.array([0.6]), samples=60, disturbance=disturbance)
    return blown.data["held"].to_numpy().tolist(), blown.weather


def held(legs: dict[str, list[float]], **told: Any) -> Any:
    return nw.learn_steady(by_depth(), legs, **told).to_dict()


def predicted(sensors: nw.SensorGrade, **told: Any) -> Any:
    told = {"conditions": nw.TransitConditions(wind=0.5, gust_time=2.0, wander=0.05, wander_time=9.0), **told}
    return nw.predict_information(by_depth(), None, sensors, (1,), u=0.5, duration=10.0, **told).to_dict()


def hull(ship: nw.Ship) -> Any:
    # The mass is felt with Coriolis forces, the flow over the rudder, fullness by the squat, the name in words.
    model = with_parts(steered(), ship=ship)
    heavy = with_parts(mmg(), ship=replace(mmg().configuration.ship, inertia=ship.inertia, x_g=ship.x_g))
    sunk = nw.squat(replace(by_depth().configuration, ship=ship), 0.5, "bow").sinkage
    return sailed(model, coriolis=True, rudder=0.1, r=0.02), sailed(heavy, rudder=0.2), sunk, ship.name


def logged(log: nw.ShipLog) -> Any:
    record = log.records[0]
    return str(log.to_dict()), log.to_dataframe().to_csv(), record.antenna


def along(waterway: nw.Waterway) -> Any:
    told = {"x": 20.0, "u": 1.0, "waterway": waterway}
    return sailed(shallow(), **told), waterway.name, waterway.origin


def bank(side: str, distance: float) -> Any:
    from narrows.waterway import Bank

    return Bank(side, np.array([0.0, 500.0]), np.full(2, distance))


def built() -> dict[str, Built]:
    """By the name of the class."""
    model, ship = steered(), mmg().configuration.ship
    propeller, rudder = mmg().configuration.propeller, mmg().configuration.rudder
    way = replace(waterway_for("paper"), depths=(np.array([0.0, 500.0]), np.array([0.3, 0.3])))
    straight = nw.StraightRun("A", 0.5)
    disturbed = nw.Disturbance(15.0, 0.8, 30.0, 1.0, 5.0)
    yawing = nw.HarmonicRun("A", "yaw", 0.4, 12.0, 1.0, 1)
    own = replace(model.configuration.ship, inertia=ship.inertia, x_g=ship.x_g)
    ours = {name: nw.SignalGrade(0.01) for name in ("y", "psi", "u", "rudder")}
    signal = nw.Signal(np.array([0.0, 1.0]), np.array([2.0, 3.0]))
    record = nw.ShipRecord("A", {"u": signal})
    return {
        "Autopilot": Built(
            nw.Autopilot(0.3, (0.1, 1.0, 0.4, 2.0), 0.01, 0.005, -0.01), controlled,
            {"y": 0.4, "gains": (0.1, 1.0, 0.4, 3.0), "rudder": 0.02, "psi": 0.01, "v": 0.01},
        ),
        "PID": Built(
            nw.PID(1.0, 2.0, 0.5, 0.02), controlled, {"kp": 1.5, "kd": 3.0, "ki": 1.0, "psi": 0.05}
        ),
        "ConstantRudder": _new("ConstantRudder", (0.1,), {"rudder": 0.2}),
        "Zigzag": Built(nw.Zigzag(-0.2, 0.02), controlled, {"rudder": -0.1, "heading": 0.1}),
        "Canal": Built(
            nw.Canal(7.0, 0.3), lambda canal: sailed(with_parts(shallow(), canal=canal)), {"width": 6.0, "depth": 0.25}
        ),
        "Water": Built(
            nw.Water(), lambda water: sailed(with_parts(paper(), water=water)), {"density": 900.0}
        ),
        "Ship": Built(
            own, hull,
            {"length": 3.0, "beam": 0.7, "draft": 0.2, "block_coefficient": 0.7, "mass": 300.0, "inertia": 2e4,
             "x_g": 0.1, "flow_straightening": 0.9, "name": "other"},
        ),
        "SteeringGear": Built(
            nw.SteeringGear(20.0, 5.0),
            lambda gear: _steered_by(gear),
            {"limit_deg": 15.0, "rate_deg": 4.0, "dead_time": 1.0, "lag": 1.0, "dead_band_deg": 25.0, "pumps": 1},
        ),
        "Propeller": Built(
            propeller, lambda part: of_mmg(propeller=part),
            {own.name: 1.1 * getattr(propeller, own.name) for own in fields(propeller)},
        ),
        "Rudder": Built(
            rudder, lambda part: of_mmg(rudder=part),
            {own.name: 1.1 * getattr(rudder, own.name) for own in fields(rudder)},
        ),
        "Disturbance": Built(
            disturbed, enveloped,
            {"heading_deg": 40.0, "offset": 1.6, "gust": 60.0, "gust_lever": 0.0, "gust_time": 1.0, "wind": 9.0,
             "steady": 20.0},
        ),
        "HarmonicRun": Built(
            yawing, measured,
            {"name": "B", "kind": "sway", "amplitude": 0.5, "period": 13.0, "speed": 0.9, "cycles": 2, "offset": 0.2,
             "depth": 0.4},
        ),
        "StraightRun": Built(
            straight, measured,
            {"name": "B", "offset": 0.6, "speed": 0.9, "duration": 20.0, "drift": 0.1, "depth": 0.4},
        ),
        "Signal": Built(
            signal, lambda told: logged(nw.ShipLog((nw.ShipRecord("A", {"u": told}),))),
            {"t": np.array([0.0, 2.0]), "values": np.array([2.0, 4.0])},
        ),
        "ShipRecord": Built(
            record, lambda told: logged(nw.ShipLog((told,))),
            {"name": "B", "signals": {"v": signal}, "antenna": (3.0, 0.0), "condition": {"draft": 10.0}},
        ),
        "ShipLog": Built(
            nw.ShipLog((record,)), logged,
            {"records": (replace(record, name="B"),), "waterway": waterway_for("paper"), "notes": ("so",)},
        ),
        "SignalGrade": Built(
            nw.SignalGrade(0.02, 1.0, 0.01, 5.0, 0.01),
            lambda grade: predicted(nw.SensorGrade("own", "", {**ours, "y": grade})),
            {"noise": 0.05, "period": 2.0, "wander": 0.05, "memory": 20.0, "zero": 0.1},
        ),
        "SensorGrade": Built(
            nw.SensorGrade("own", "a test's", ours), predicted,
            {"name": "other", "words": "another's", "signals": {**ours, "y": nw.SignalGrade(0.1)}},
        ),
        "TransitConditions": Built(
            nw.TransitConditions(0.5, 0.5, 0.1, 0.3, 2.0, 0.05, 9.0),
            lambda conditions: predicted(nw.SensorGrade("own", "", ours), conditions=conditions),
            {"wind": 0.4, "windage": 0.4, "wind_lever": 0.2, "gust": 0.5, "gust_time": 4.0, "wander": 0.1,
             "wander_time": 20.0, "gust_correlation": 0.5},
        ),
        "SteadyConditions": Built(
            nw.SteadyConditions(),
            lambda conditions: held(held_legs(), conditions=conditions),
            {"wind": 4.0, "windage": 0.5, "wind_lever": 0.1, "wind_change": 0.5, "rudder_zero_deg": 2.0,
             "drift_zero_deg": 2.0, "y_zero": 0.2, "yaw_rate_deg": 0.5, "yaw_change_deg": 5.0,
             "sway_change": 0.2, "leg_time": 5.0, "y_error": 0.1, "u_error": 0.2, "rudder_error_deg": 2.0,
             "drift_error_deg": 0.3},
        ),
        "Tank": Built(
            nw.Tank(), planned,
            {"run_length": 30.0, "clearance": 2.5, "heading": 5.0, "speeds": (0.6,), "depths": (0.3, 0.5),
             "reach": 0.5},
        ),
        "Waterway": Built(
            way, along,
            {"line": nw.straight_waterway(nw.Canal(7.0), 100.0).line, "starboard": bank("starboard", 3.0),
             "port": bank("port", 3.0), "depths": (np.array([0.0, 500.0]), np.array([0.4, 0.4])), "current": 0.5,
             "level": 0.1, "step": 0.5, "name": "other", "origin": (5.0, 52.0), "current_across": 0.02,
             "current_shear": 0.01},
        ),
        "Configuration": Built(
            mmg().configuration, lambda own: _configured(own),
            {"ship": replace(ship, beam=1.3), "canal": nw.Canal(13.0), "water": nw.Water(1025.0),
             "depths": {"a": 2.0}, "steering": nw.SteeringGear(10.0), "propeller": replace(propeller, revolutions=9.0),
             "rudder": replace(rudder, area=0.06), "others": None},
        ),
    }  # fmt: skip


def _new(name: str, told: tuple, others: Any) -> Built | None:
    """What the engine brings; absent until it is in."""
    if not hasattr(nw, name):
        return None
    usual = getattr(nw, name)(*told)
    if others is None:
        others = {own.name: ((0.0, 0.2), (2.0, -0.1)) for own in fields(usual)}
    return Built(usual, controlled, others)


def _steered_by(gear: nw.SteeringGear) -> Any:
    law = (getattr(nw, "ConstantRudder", None) or nw.Held)(0.6)
    model = with_parts(steered(), steering=gear)
    try:
        return sailed(model, controller=law)
    except TypeError:
        return sailed(model, helm=law)


def _configured(configuration: nw.Configuration) -> Any:
    law = (getattr(nw, "ConstantRudder", None) or nw.Held)(0.4)
    model = replace(mmg(), configuration=configuration)
    try:
        return sailed(model, controller=law), dict(configuration.depths)
    except TypeError:
        return sailed(model, helm=law), dict(configuration.depths)


BUILT = {name: own for name, own in built().items() if own is not None}
HELD_ELSEWHERE = {("Configuration", "others"), ("Configuration", "notes")}
"""Actuators of one's own: tests/property/test_actuators.py; notes: tests/unit/test_assumptions.py."""


def public_classes() -> set[str]:
    return {name for name in nw.__all__ if isinstance(getattr(nw, name), type)}


def test_every_public_class_is_built_or_made_or_vocabulary() -> None:
    known = {*BUILT, *MADE, *VOCABULARY, *FED, *INTERFACES}
    assert public_classes() <= known, f"{sorted(public_classes() - known)}: say here what they are"


FIELDS = [
    (name, own.name)
    for name, one in BUILT.items()
    if is_dataclass(one.usual)
    for own in fields(one.usual)
    if own.init and (name, own.name) not in HELD_ELSEWHERE
]


@pytest.mark.parametrize(("name", "field"), FIELDS)
def test_another_value_of_a_field_gives_another_answer(name: str, field: str) -> None:
    own = BUILT[name]
    assert field in own.others, f"{name}.{field} is public: give it another value here"
    assert own.answer(own.usual) != own.answer(replace(own.usual, **{field: own.others[field]}))


def in_open_water() -> nw.Model:
    return nw.published("yasukawa2015_kvlcc2")


IGNORED = {
    "a rudder angle where no term feels a rudder": lambda: nw.simulate(paper(), y=0.5, duration=1.0, rudder=0.2),
    "the same in a fleet": lambda: nw.ensemble(paper(), y=0.5, duration=1.0, rudder=0.2),
    "an inertia in surge where the speed is held": lambda: nw.simulate(paper(), duration=1.0, surge_inertia=300.0),
    "the same for many": lambda: nw.ensemble(paper(), y=0.0, duration=1.0, surge_inertia=300.0),
    "a push ahead where the speed is held": lambda: nw.simulate(paper(), duration=1.0, X=5.0),
    "its schedule": lambda: nw.simulate(paper(), duration=1.0, X=[(0.0, 5.0)]),
    "the same push on many": lambda: nw.ensemble(paper(), y=0.0, duration=1.0, X=5.0),
    "a sinkage that no term feels": lambda: nw.ensemble(
        in_open_water(), duration=1.0, contact="none", heave=[0.0, 0.1]
    ),
    "rate of the propeller where there is none": lambda: nw.ensemble(paper(), y=0.5, duration=1.0, revolutions=9.0),
    "a Coriolis force of a mass that nobody gave": lambda: nw.simulate(paper(), duration=1.0, coriolis=True),
    "a rudder angle where no term feels it, for eigenvalues": lambda: nw.stability(paper(), rudder=0.2),
}


@pytest.mark.parametrize("call", IGNORED.values(), ids=IGNORED)
def test_what_would_be_ignored_is_refused(call: Callable[[], Any]) -> None:
    with pytest.raises(nw.InputError):
        call()


def test_a_tank_that_lets_no_ship_yaw_still_gets_a_plan_or_a_sentence() -> None:
    """It ended in a raw error about an array of no size."""
    try:
        plan = nw.plan_tests(shallow().configuration, 4, tank=nw.Tank(heading=5.0))
    except nw.InputError:
        return
    assert len(plan.runs) == 4
