"""For each argument of each public function another value: the answer must differ, or the value is refused."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from cases import mmg, paper, steered, waterway_for

import narrows as nw
from faults import scaled
from logs import bent_waterway, kvlcc2, zigzag
from narrows.captive.measured import measured_files
from narrows.empirical.formulas import read_calibration
from narrows.ship.actuators import Actuator, Part, number_in
from readers_files import TURNED
from tables import DTC_SHIP, frame_of, short_twin, written


@dataclass(frozen=True)
class Other:
    """Another value of an argument; it counts under some other arguments than the usual."""

    value: Any
    under: Mapping[str, Any] = field(default_factory=dict)
    refused: bool = False
    shown: bool = False


def under(value: Any, **others: Any) -> Other:
    """A value that counts where others are so."""
    return Other(value, others)


def refused(value: Any, **others: Any) -> Other:
    """A value that must be refused."""
    return Other(value, others, refused=True)


def shown(value: Any) -> Other:
    """A value that changes no answer, but what is shown on stderr."""
    return Other(value, shown=True)


@dataclass(frozen=True)
class Entry:
    """A public function, the arguments of a usual call, and another value of each."""

    usual: Mapping[str, Any]
    others: Mapping[str, Any]
    answer: Callable[..., Any] | None = None
    """What to compare where the function returns nothing."""


def tested(model: nw.Model) -> nw.Model:
    """A model whose tests covered every speed, offset and width."""
    every = dict.fromkeys(("speed", "abs_y", "depth_to_draft", "width_to_beam"), (0.0, 1e6))
    return replace(model, data_range=replace(model.data_range, **every))


@cache
def uncertain() -> nw.Model:
    """With a covariance, to draw from."""
    values = np.array([steered().coefficients[name] for name in steered().terms.names])
    return replace(steered(), covariance=np.diag((0.05 * values) ** 2))


@cache
def shallow() -> nw.Model:
    """With a depth that its bank feels."""
    configuration = replace(paper().configuration, canal=nw.Canal(7.0, 0.3))
    return replace(paper(), configuration=configuration, terms=nw.with_bank(nw.PAPER, "keel_gap"))


@cache
def by_depth() -> nw.Model:
    """A steered ship by weak banks, uncertain, in a canal whose depth is known."""
    model = replace(uncertain(), configuration=replace(uncertain().configuration, canal=nw.Canal(7.0, 0.3)))
    return model.with_coefficients(b_bank=0.05, c_bank=0.02)


@cache
def held_legs(rudder: float = 0.03) -> dict[str, list[float]]:
    """A ship held to either side."""
    return {"y": [0.5, -0.5], "u": [0.5, 0.5], "rudder": [rudder, -rudder], "drift": [0.02, -0.02]}


def sensed(noise: float) -> nw.SensorGrade:
    """Sensors of a tank."""
    return nw.SensorGrade("a tank's", "", {name: nw.SignalGrade(noise) for name in ("x", "y", "psi", "u", "rudder")})


@cache
def other_tests() -> nw.CaptiveTests:
    return short_twin(seed=1)


@cache
def zigzagging(rudder: float = 0.17) -> nw.Voyage:
    told = {"duration": 60.0, "dt": 0.1, "contact": "none"}
    law = nw.Zigzag(rudder, 0.17)
    model = steered().in_open_water()
    try:
        return nw.simulate(model, **told, controller=law)
    except TypeError:
        return nw.simulate(model, **told, helm=law)


@cache
def circling(rudder: float = 0.3) -> nw.Voyage:
    return nw.simulate(steered().in_open_water(), duration=200.0, dt=0.1, contact="none", rudder=rudder)


@cache
def fleet(x: float = 0.0) -> xr.Dataset:
    return nw.ensemble(uncertain(), y=[0.5, 1.5], psi=x, samples=6, duration=30.0)


@dataclass(frozen=True)
class Thruster(Part):
    """A bow thruster of the test's own."""

    SECTION: ClassVar[str] = "thruster"
    POSITION: ClassVar[str] = "thrust"
    power: float = number_in("N", "largest thrust")


@cache
def too_fast() -> nw.Model:
    """A ship with a fifth of its draft under the keel, too fast for that."""
    model = steered()
    return replace(model, configuration=replace(model.configuration, canal=nw.Canal(7.0, 0.2)))


BOW = Actuator("thrust", "1", "share of the thrust", rest=0.0, parts=(Thruster,))
STATE = {"x": under(2.0, waterway=waterway_for("paper")), "psi": 0.1, "v": 0.05, "r": 0.02}
FORCES = {"X": under(20.0, surge="free", surge_inertia=300.0), "Y": 5.0, "N": 5.0}
CHOICES = {
    "surge": under("free", model=mmg()), "surge_inertia": under(400.0, surge="free", X=5.0, base=300.0),
    "coriolis": under(True, model=steered()), "contact": "midship", "bottom": under(False, model=too_fast()),
}  # fmt: skip
FREE = {name: value for name, value in CHOICES.items() if name not in ("contact", "bottom")}
VARIED = {
    "x": refused(np.nan), "y": 0.7, "psi": 0.1, "u": 1.1, "v": 0.05, "r": 0.02, "Y": 5.0, "N": 5.0, "width": 6.0,
    "length": 3.0, "beam": 0.7, "draft": 0.2, "density": 900.0, "b_bank": 1.5, "c_vv": 600.0, "depth": 0.4,
    "block_coefficient": refused(1.5), "heave": refused(np.nan),
    "rudder": under(0.2, model=steered()), "X": under(20.0, surge="free", surge_inertia=300.0),
    "revolutions": under(8.0, model=mmg()), "flow_straightening": under(0.9, model=steered(), rudder=0.2),
}  # fmt: skip


class Table:
    """The table; files that it needs are in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @cached_property
    def ship(self) -> Path:
        path = self.folder / "ship.toml"
        path.write_text(DTC_SHIP)
        return path

    @cached_property
    def wider(self) -> Path:
        path = self.folder / "wider.toml"
        path.write_text(DTC_SHIP.replace("7.0", "8.0"))
        return path

    @cached_property
    def thrusting(self) -> Path:
        path = self.folder / "thruster.toml"
        path.write_text(DTC_SHIP + "\n[thruster]\npower = 3.0\n")
        return path

    def captive(self, seed: int) -> Path:
        return written(frame_of(short_twin(seed=seed)), self.folder / f"tests{seed}.csv")

    def model(self, model: nw.Model, name: str) -> Path:
        nw.save_model(model, self.folder / name)
        return self.folder / name

    def waterway(self, ship: str, name: str) -> Path:
        nw.write_waterway(replace(waterway_for(ship), origin=(5.0, 52.0)), self.folder / name)
        return self.folder / name

    @cached_property
    def entries(self) -> dict[str, Entry]:
        """By the name of the function."""
        return {
            **self.simulation, **self.safety, **self.logbook, **self.models, **self.identification, **self.files,
        }  # fmt: skip

    @property
    def simulation(self) -> dict[str, Entry]:
        start = {"model": paper(), "y": 0.5, "u": 1.0, "duration": 30.0, "dt": 0.05}
        law = nw.Zigzag(0.2, 0.1)
        voyage = {
            "model": steered(), "y": 0.6, "u": 1.1, "duration": 5.0, "dt": 0.5, **STATE, **FORCES, **CHOICES,
            "rudder": under(0.1, model=steered()), "waterway": under(waterway_for("paper"), x=3.0),
            "controller": under(law, model=steered()), "hold": under(0.2, model=steered()),
        }  # fmt: skip
        run = {
            "model": steered(), "duration": 5.0, "dt": 0.5, "samples": under(3, model=uncertain()),
            "seed": under(1, model=uncertain(), samples=3), **CHOICES, "workers": refused(-1),
            "progress": shown(True),
            "waterway": under(waterway_for("paper"), x=3.0), "controller": under(law, model=steered()),
            "hold": under(0.2, model=steered()), **VARIED,
        }  # fmt: skip
        modes = {"bank": False, "y": 0.7, "u": 1.2, "psi": 0.1, "v": 0.1, "r": 0.1, "width": 6.0, "b_bank": 2.0}
        return {
            "simulate": Entry(start, voyage),
            "ensemble": Entry({**start, "model": shallow(), "y": [0.5, -1.0]}, {**run, "y": [0.5, -1.1]}),
            "stability": Entry({"model": paper(), "y": 0.5, "u": 1.0}, {"model": steered(), **modes}),
            "derivative": Entry(
                {"model": steered(), "state": (0.0, 0.5, 0.0, 1.0, 0.1, 0.02)},
                {"model": paper(), "state": (0.0, 0.6, 0.0, 1.0, 0.1, 0.02), **FORCES, **FREE},
            ),
            "latex": Entry(
                {"table": nw.PAPER},
                {"table": nw.SPEED, "coefficients": paper().coefficients, "forces": ("X",)},
            ),
            "jacobian": Entry(
                {"model": steered(), "y": 0.5, "u": 1.0, "v": 0.1, "r": 0.02},
                {"model": paper(), "y": 0.6, "u": 1.1, "x": 2.0, "psi": 0.1, "v": 0.05, "r": 0.01, **FORCES, **FREE},
                answer=lambda found: found.to_dict(),
            ),
            "sensitivities": Entry(
                {"model": steered(), "by": ("y", "b_bank"), "y": 0.5, "u": 1.0, "duration": 1.0, "dt": 0.1},
                {"model": paper(), "by": ("y", "c_bank"), "y": 0.6, "u": 1.1, "duration": 1.5, "dt": 0.05},
                answer=lambda found: found.slopes,
            ),
            "grounding_probability": Entry(
                {"voyages": fleet(), "distance": 8.0, "over": "sample"},
                {"voyages": fleet(-0.1), "distance": 8.3, "over": "y"},
            ),
            "turning_circle": Entry(
                {"model": steered(), "rudder": 20.0, "speed": 1.0},
                {"model": mmg(), "rudder": 15.0, "speed": 1.1, "dt": 0.2, "duration": 200.0},
            ),
            "zigzag": Entry(
                {"model": steered(), "rudder": 10.0, "heading": 10.0, "speed": 1.0},
                {"model": mmg(), "rudder": 15.0, "heading": 8.0, "speed": 1.1, "dt": 0.2, "duration": 90.0},
            ),
            "crash_stop": Entry(
                {"model": mmg(), "speed": 1.0, "revolutions": -8.0},
                {"model": nw.published("yasukawa2015_kvlcc2_full"), "speed": 1.1, "revolutions": -9.0, "delay": 5.0,
                 "reversal": 10.0},
            ),
            "show_versions": Entry({}, {}),
            "overshoots": Entry(
                {"voyage": zigzagging(), "zigzag": nw.Zigzag(0.17, 0.17)},
                {"voyage": zigzagging(0.2), "zigzag": nw.Zigzag(0.17, 0.1)},
            ),
            "sail_trials": Entry(
                {"model": steered().in_open_water(), "speed": 1.0, "turn_deg": 20.0, "zigzags": ((10, 10),)},
                {"model": mmg().in_open_water(), "speed": 0.8, "turn_deg": 15.0, "zigzags": ((20, 20),), "dt": 0.2},
            ),
        }  # fmt: skip

    @property
    def safety(self) -> dict[str, Entry]:
        usual = {"model": by_depth(), "y": np.array([0.0, 0.6]), "u": np.array([0.3, 0.6]), "samples": 4}
        others = {
            "model": replace(by_depth(), covariance=4 * by_depth().covariance), "y": np.array([0.0, 0.7]),
            "u": np.array([0.3, 0.5]), "disturbance": nw.Disturbance(gust=300.0, gust_lever=1.0),
            "reserve": 0.9, "keel": 0.13, "samples": 5,
            "seed": 1, "walls": (3.0, 2.5), "bank": "sloping", "controller": "human", "workers": refused(-1),
            "progress": shown(True), "curvature": 0.02, "current": under(0.1, curvature=0.02),
        }  # fmt: skip
        course = {"model": by_depth(), "y": 0.5, "u": 1.0}
        return {
            "safe_envelope": Entry(usual, others),
            "bank_force": Entry(
                {"model": by_depth(), "y": 0.5, "psi": 0.0, "u": 1.0},
                {"model": replace(by_depth(), covariance=4 * by_depth().covariance), "y": 0.7, "psi": 0.3, "u": 1.2,
                 "starboard": 3.0, "port": 3.0, "depth": under(0.4, slope_starboard=0.5),
                 "slope_starboard": under(1.0, depth=0.5),
                 "slope_port": under(1.0, depth=0.5)},
            ),
            "envelope_along": Entry(
                {"model": tested(steered()), "waterway": waterway_for("steered"), "places": [30.0],
                 "y": [0.0], "u": [0.2, 0.6], "samples": 4},
                {"model": refused(paper()), "waterway": refused("canal"), "places": [60.0], "y": [0.5],
                 "u": [0.2, 0.5]},
            ),
            "outside_rules": Entry(
                {"configuration": by_depth().configuration},
                {"configuration": mmg().configuration, "bank": "gentle", "walls": (3.0, 2.5)},
            ),
            "steady_course": Entry(
                course,
                {"model": mmg(), "samples": 3, "seed": under(1, samples=3), "workers": refused(-1), "y": 0.6,
                 "u": 1.1, "b_bank": 2.0},
            ),
            "self_propulsion": Entry(
                {"model": mmg(), "u": 1.0}, {"model": mmg().with_coefficients(R_0=0.03), "u": 1.2}
            ),
            "wind_force": Entry(
                {"speed": 10.0, "area": 5.0, "coefficient": 1.0}, {"speed": 11.0, "area": 6.0, "coefficient": 0.9}
            ),
        }  # fmt: skip

    @property
    def logbook(self) -> dict[str, Entry]:
        surer = replace(by_depth(), covariance=by_depth().covariance / 4)
        breeze = nw.TransitConditions(wind=0.5, gust_time=2.0, wander=0.05, wander_time=9.0)
        plan = {"model": by_depth(), "offsets": [0.3, 0.5], "speeds": [0.4, 0.5], "legs": 2}
        return {
            "predict_information": Entry(
                {"model": by_depth(), "sensors": sensed(0.01), "u": 0.5, "duration": 20.0,
                 "transits": (1,), "conditions": breeze},
                {"model": surer, "waterway": nw.straight_waterway(nw.Canal(6.0, 0.3), 60.0),
                 "sensors": sensed(0.02), "transits": (2,), "u": 0.45, "duration": 15.0, "targets": ("c_helm",),
                 "conditions": replace(breeze, wind=0.4), "seed": 1},
                answer=lambda found: found.to_dict(),
            ),
            "learn": Entry(
                {"model": kvlcc2(), "log": [zigzag()], "spread": 0.1, "sensors": "basin"},
                {"model": kvlcc2().with_coefficients(N_v=-0.12), "log": [zigzag(10.0)], "free": ("N_v",),
                 "sensors": "vdr", "spread": 0.2, "gusts": True, "asymmetry": False,
                 "waterway": bent_waterway(length=9000.0), "coriolis": True},
                answer=lambda found: found.to_dict(),
            ),
            "estimate_states": Entry(
                {"model": kvlcc2(), "log": zigzag()},
                {"model": kvlcc2().with_coefficients(N_v=-0.12), "log": zigzag(10.0), "sensors": "ais", "smooth": True},
                answer=lambda found: found.mean.tolist(),
            ),
            "learn_steady": Entry(
                {"model": by_depth(), "observations": held_legs()},
                {"model": surer, "observations": held_legs(0.05), "conditions": nw.SteadyConditions(wind=1.0)},
                answer=lambda found: found.to_dict(),
            ),
            "plan_steady": Entry(
                plan,
                {"model": surer, "offsets": [0.4], "speeds": [0.45], "legs": 4, "targets": ("c_helm",),
                 "conditions": nw.SteadyConditions(wind=1.0)},
                answer=lambda found: found.to_dict(),
            ),
        }  # fmt: skip

    @property
    def models(self) -> dict[str, Entry]:
        # At 1 m/s of another ship the primes are others; with another system too.
        return {
            "at_depth": Entry({"model": shallow(), "depth": 0.35}, {"model": by_depth(), "depth": 0.4}),
            "borrow_rudder": Entry(
                {"model": paper(), "lender": steered()},
                {"model": shallow(), "lender": steered().with_coefficients(c_helm=4.0)},
            ),
            "with_transverse_thrust": Entry(
                {"model": mmg(), "share": 1.0}, {"model": nw.published("yasukawa2015_kvlcc2"), "share": -1.0}
            ),
            "nondimensional": Entry(
                {"model": paper(), "system": "prime2", "speed": 1.0},
                {"model": steered(), "system": "prime1", "speed": 2.0},
            ),
            "scale_model": Entry(
                {"model": shallow(), "length": 300.0},
                {"model": steered(), "length": 200.0, "density": 1025.0, "width": 700.0, "depth": 30.0},
            ),
            "squat": Entry(
                {"ship": shallow(), "u": 0.5},
                {"ship": by_width(), "u": 0.6, "gives": "bow",
                 "formula": under("tuck_bow", gives="bow", base="icorels")},
            ),
            "choke_speed": Entry({"ship": shallow()}, {"ship": by_width()}),
            "equivalent_wall": Entry(
                {"profile": [(10.0, 0.0), (20.0, 8.0)], "depth": 5.0},
                {"profile": [(10.0, 0.0), (25.0, 8.0)], "depth": 6.0},
            ),
            "with_bank": Entry(
                {"table": nw.PAPER, "form": "tuck"}, {"table": nw.SPEED, "form": "delta", "name": "other"}
            ),
            "straight_waterway": Entry(
                {"canal": nw.Canal(7.0), "length": 50.0},
                {"canal": nw.Canal(8.0), "length": 60.0, "heading": 1.0},
            ),
            "published": Entry({"name": "mikkelsen2025_dtc"}, {"name": "yasukawa2015_kvlcc2"}),
            "ready_ships": Entry({}, {}),
            "with_astern_thrust": Entry(
                {"propeller": nw.Propeller(6.0, 1.5, 0.3, 0.4, -0.4, 0.0)},
                {"propeller": mmg().configuration.propeller},
            ),
            "estimate_model": Entry(
                {"ship": nw.Ship(200.0, 30.0, 10.0, 0.65), "canal": nw.Canal(300.0, 15.0)},
                {"ship": nw.Ship(210.0, 30.0, 10.0, 0.65), "canal": nw.Canal(300.0, 16.0), "water": nw.Water(1000.0),
                 "kind": "bulk", "speed": 6.0, "propeller": nw.Propeller(6.0, 1.5, 0.3, 0.4, -0.4, 0.0),
                 "rudder": nw.Rudder(40.0, 2.7, 1.0, 0.5, 0.7, -0.9, 0.4, 0.4),
                 "steering": nw.SteeringGear(30.0, 3.0),
                 "calibration": replace(read_calibration(), correlation=np.eye(11))},
            ),
        }  # fmt: skip

    @property
    def identification(self) -> dict[str, Entry]:
        own = {"tests": short_twin()}
        conditions = nw.measured_tests("kcs")
        fitted = {"tests": other_tests(), "terms": "speed", "balance": "rows",
                  "accelerations": "motion", "fixed": {"b_bank": 0.0}, "bounds": {"b_vdot": (0.0, 700.0)},
                  "errors": nw.RunErrors(gain=0.05), "pool": under("depth", tests=conditions, terms="paper+keel_gap"),
                  "pass_over": refused((), tests=turned(), base=("rudder",))}  # fmt: skip
        plan = {"configuration": paper().configuration, "runs": 2}
        unread = under(self.wider, tests=self.captive(0), base=self.ship)
        quick = {"runs": (nw.HarmonicRun("A", "yaw", 0.4, 12.0, 1.0, 1),), "rate": 5.0}
        return {
            "identify": Entry(own, {**fitted, "ship": unread}),
            "identify_conditions": Entry(
                {"tests": conditions},
                {"tests": short_twin(), "condition": "C0101A02", "balance": "rows", "ship": unread},
            ),
            "compare": Entry(
                {**own, "tables": ("paper", "speed")},
                {"tests": other_tests(), "tables": ("paper", "mixed"), "balance": "rows",
                 "ship": unread},
            ),
            "explain": Entry(
                {"model": nw.identify(short_twin()).model, **own, "tables": ("paper",)},
                {"model": nw.identify(other_tests()).model, "tests": other_tests(), "tables": ("paper", "speed"),
                 "ship": unread},
            ),
            "plan_tests": Entry(
                plan,
                {"configuration": mmg().configuration, "runs": 3, "tank": nw.Tank(speeds=(0.6,)), "terms": nw.SPEED,
                 "targets": ("b_v",),
                 "noise": {"X": 1.0, "Y": 0.1, "N": 0.1},
                 "correlation_time": 2.0, "after": short_twin(), "errors": nw.RunErrors(0.0, 0.0, 0.0)},
            ),
            "twin": Entry(
                quick,
                {"truth": paper().with_coefficients(b_r=50.0), "runs": (nw.StraightRun("B", 0.5),), "noise": {},
                 "correlation_time": 1.0, "rate": 6.0, "seed": 1},
            ),
            "measured_tests": Entry({"name": "kcs"}, {"name": "lataire2009", "where": "type == 'PMMY2'"}),
        }  # fmt: skip

    @property
    def files(self) -> dict[str, Entry]:
        models = [self.folder / name for name in ("out.toml", "elsewhere.toml")]
        ways = [self.folder / name for name in ("out.geojson", "elsewhere.geojson")]
        read, streamed = ({name: self.captive(0), "ship": self.ship} for name in ("table", "path"))
        reading = {
            "ship": self.wider, "where": "u < 0.9", "actuators": refused((), ship=self.thrusting, base=(BOW,)),
            "mapping": refused({"columns": {"no such header": "u"}}),
        }  # fmt: skip
        log, other = ({"log": logged(rudder)} for rudder in (0.1, 0.2))
        understood = {
            **other, "waterway": bent_waterway(), "mapping": {"positive": {"rudder": "port"}},
            "units": {"rudder": "deg"}, "gap": 50.0, "mmsi": refused(244000000),
        }  # fmt: skip
        model = {"path": self.model(paper(), "paper.toml")}
        own = replace(nw.PAPER, name="own")
        return {
            "read_captive": Entry(read, {"table": self.captive(1), **reading}),
            "stream_captive": Entry(
                streamed, {"path": self.captive(1), **reading}, answer=lambda kept: nw.identify(kept).coefficients
            ),
            "read_log": Entry(log, understood),
            "check_log": Entry(
                {"log": [scaled(0.5, "rudder")(zigzag())], "model": kvlcc2()},
                {"log": [replace(zigzag(), signals={})], "model": mmg(), "waterway": bent_waterway(), "sensors": "rtk",
                 "spread": 0.02},
                answer=lambda found: found.to_dict(),
            ),
            "stream_log": Entry(
                log, understood, answer=lambda kept: [(own.antenna, own.condition, own.to_dataframe()) for own in kept]
            ),
            "read_ship": Entry(
                {"path": self.ship}, {"path": self.wider, "actuators": refused((), path=self.thrusting, base=(BOW,))}
            ),
            "load_model": Entry(
                model,
                {"path": self.model(steered(), "steered.toml"),
                 "terms": under(replace(own, ties=()), base=own,
                                path=self.model(replace(paper(), terms=own), "own.toml"))},
            ),
            "save_model": Entry(
                {"model": paper(), "path": models[0]}, {"model": steered(), "path": models[1]},
                answer=lambda _: sorted((path.name, path.read_bytes()) for path in models if path.exists()),
            ),
            "read_waterway": Entry(
                {"path": self.waterway("paper", "a.geojson")},
                {
                    "path": self.waterway("mmg+delta", "b.geojson"),
                    "width": under(9.0, depth=0.5),
                    "depth": 0.5,
                },
            ),
            "write_waterway": Entry(
                {"waterway": replace(waterway_for("paper"), origin=(5.0, 52.0)), "path": ways[0]},
                {"waterway": replace(waterway_for("paper"), origin=(5.0, 53.0)), "path": ways[1]},
                answer=lambda _: sorted((path.name, path.read_bytes()) for path in ways if path.exists()),
            ),
        }  # fmt: skip


def logged(rudder: float) -> dict[str, Any]:
    """A log of four rows, on earth."""
    place = {"lon": [5.001, 5.002, 5.003, 5.004], "lat": [52.004, 52.005, 52.006, 52.007], "hdg": [0.1, 0.1, 0.2, 0.2]}
    return {"t": [0.0, 5.0, 10.0, 100.0], "rudder": [rudder] * 4, **place}


@cache
def turned() -> nw.CaptiveTests:
    """Tests in which the rudder moves."""
    return nw.read_captive(*measured_files("kcs"), TURNED).by_condition()["C0101A02"]


@cache
def by_width() -> nw.Configuration:
    return replace(shallow().configuration, canal=nw.Canal(5.0, 0.3))


@cache
def mirrored_density() -> nw.Model:
    return replace(paper(), configuration=replace(paper().configuration, water=nw.Water(1025.0)))
