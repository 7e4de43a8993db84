"""What ships do in truth: transits of eight minutes by people who steer, and of whom half let go of the helm once."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

import narrows as nw
from narrows.control.regulator_law import HeldLine, Regulator
from narrows.estimation.states import ProcessNoise
from narrows.identification.conditions import bundled_ship
from narrows.simulation.controllers import Asked
from narrows.simulation.grid import sampled
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import PARAMETER, steering_of
from narrows.terms.tables import table_named
from narrows.warning.forecasting.forecaster import BridgePredictor

SPEED, DURATION, DT = 4.5, 480, 1.0
LENGTH, WIDTH, DEPTH = 230.0, 300.0, 16.2
LINES = np.arange(-60.0, 61.0, 20.0)
"""That ships are held on [m]."""
CHANGES, ORDERS = 120, 10
"""When half of them are brought 20 m to a side [s], and between two orders of the helm."""
AREA, LEVER, WIND, GUST = 6000.0, 15.0, 14.0, 60
"""Of the ship above water [m2], of the wind forward of midship [m]; fastest wind [m/s], and how long it blows [s]."""
STRENGTH, CURRENT, BIAS = 0.15, 0.3, np.radians(0.5)
"""Standard deviations: of the banks' strength, the current along [m/s], and the rudder's indicator."""


@dataclass(frozen=True)
class Physics:
    """What the ships are, that the warning takes for another.

    Parameters
    ----------
    words : str
        For the table.
    form : str
        Of the bank's terms: ``as modelled``, or ``distance``.
    spread : float
        Times the standard deviations of the coefficients.
    depth : float [m]
        Of the water.
    """

    words: str
    form: str = "as modelled"
    spread: float = 1.0
    depth: float = DEPTH


@cache
def modelled() -> nw.Model:
    """The ship as the warning knows it."""
    return bundled_ship(LENGTH, WIDTH, DEPTH, table_named("speed+helm"))


def true_model(physics: Physics) -> nw.Model:
    """The ship as it is, before its coefficients are drawn."""
    known = modelled()
    if physics.form == "distance":
        return _other_form(known)
    model = known if physics.depth == DEPTH else nw.at_depth(known, physics.depth).model
    return replace(model, covariance=model.covariance * physics.spread**2)


def _other_form(known: nw.Model) -> nw.Model:
    """Banks whose force goes with the distance, as strong as those of the model at 40 m off the middle."""
    table, at = table_named("steered+distance"), nw.Motion.at(y=40.0, u=SPEED)
    shared = [name for name in table.names if name in known.coefficients]
    values = {name: known.coefficients.get(name, 0.0) for name in table.names}
    values |= {term.name: 1.0 for term in table.terms if term.from_bank}
    bare = nw.Model(known.configuration, table, values)
    wanted, unit = known.bank_forces(at), bare.bank_forces(at)
    scales = {
        term.name: wanted[force] / unit[force]
        for force, terms in table.forces.items() for term in terms if term.from_bank and unit[force]
    }  # fmt: skip
    covariance = np.zeros((len(table.names), len(table.names)))
    there, here = ([names.index(name) for name in shared] for names in (table.names, known.terms.names))
    covariance[np.ix_(there, there)] = known.covariance[np.ix_(here, here)]
    banks = [table.names.index(name) for name in scales]
    covariance[banks], covariance[:, banks] = 0.0, 0.0
    return replace(bare.with_coefficients(**scales), covariance=covariance)


@dataclass
class Transits:
    """Ships on their way, a lane each.

    Parameters
    ----------
    physics : Physics
        What they are.
    count, seed : int
        How many, and of all that is drawn.
    """

    physics: Physics
    count: int
    seed: int
    state: dict[str, np.ndarray] = field(init=False)

    def __post_init__(self) -> None:
        model, n = true_model(self.physics), self.count
        self.random = draw = np.random.default_rng(self.seed)
        self.coefficients = {name: np.array(one) for name, one in sampled(model, n, self.seed).items()}
        self.banks = [term.name for term in model.terms.terms if term.from_bank]
        first = draw.choice(LINES, n)
        self.lines = first, np.clip(first + draw.choice([-20.0, 0.0, 20.0], n), LINES[0], LINES[-1])
        self.upset = np.arange(n) % 2 == 0
        self.when, self.lasts = draw.uniform(180, 300, n), draw.uniform(60, 150, n)
        self.size, self.away = draw.uniform(0.5, 3.0, n), draw.uniform(0, 120, n)
        self.blows = draw.uniform(60, 400, n)
        self.gust = nw.wind_force(1.0, AREA) * draw.uniform(0, WIND, n) ** 2 * draw.choice([-1, 1], n)
        self.strength = 1 + STRENGTH * draw.standard_normal(n)
        self.current, self.bias = (size * draw.standard_normal(n) for size in (CURRENT, BIAS))
        self.contact, self.least = np.full(n, np.inf), np.full(n, np.inf)
        self._helms = [helm(line) for line in self.lines]
        self._memory: Mapping[str, Any] = {}
        self._begin(SimulatedShip(model, "held"))

    def _begin(self, ship: SimulatedShip) -> None:
        n, line = self.count, self._helms[0].lines[0]
        psi = line.psi + BIAS * self.random.standard_normal(n)
        columns = {"x": 0.0, "y": line.y, "u": SPEED, "v": line.v, "r": 0.0, "t": 0.0, "rudder": line.rudder}
        columns |= {"cos_psi": np.cos(psi), "sin_psi": np.sin(psi)}
        self.state = {name: np.full(n, column, float) for name, column in columns.items()}
        self.order, self.ship, each = self.state["rudder"].copy(), ship, np.zeros(n)
        run = KernelRun(ship, DT, DT, steering=steering_of(Asked(), ship.actuators))
        values = {**self.state, **self.coefficients, "psi": each, "X": each, "Y": each, "N": each, "push_end": np.inf}
        self._sailing = run.prepared({**values, PARAMETER("order"): each}, n, 1)
        self._constants = run._system({**values, PARAMETER("order"): each}).constants
        self._inputs = {name: place for place, name in enumerate(self._sailing.kernel.VESSEL_INPUTS)}
        self._values, self._walks = ship.values(), ProcessNoise.of_length(LENGTH).by_state()

    @property
    def alive(self) -> np.ndarray:
        """Which have met no bank."""
        return np.isinf(self.contact)

    @property
    def psi(self) -> np.ndarray:
        """Headings."""
        return np.arctan2(self.state["sin_psi"], self.state["cos_psi"])

    @property
    def indicated(self) -> np.ndarray:
        """The rudder as the bridge sees it."""
        return self.state["rudder"] - self.bias

    def step(self, t: int) -> None:
        """Sail a second."""
        self._steer(t)
        self._load(t)
        self._sailing()
        hit = (self._sailing.codes[:, 0] != 0) & self.alive
        self.contact[hit] = t + DT
        going = self.alive
        for name, column in zip(self._sailing.kernel.KEPT_NAMES, self._sailing.end.T, strict=True):
            if name in self.state and name != "t":
                self.state[name] = np.where(going, column, self.state[name])
        for name in ("u", "v", "r"):
            self.state[name] += self._walks[name] * self.random.standard_normal(self.count) * going
        self.state["x"] += self.current * DT * going
        self.least = np.where(going, np.minimum(self.least, self.clearance()), self.least)

    def clearance(self) -> Any:
        """Of the hull's corners to the banks [m]."""
        hull, state = self.ship.model.configuration.ship, self.state
        return BridgePredictor(hull, WIDTH / 2, state["y"], self.psi, state["u"], state["v"], state["r"]).now

    def _steer(self, t: int) -> None:
        if t % ORDERS:
            return
        law = self._helms[int(t > CHANGES)]
        ship, gear = self.state, self.ship.model.configuration.gear
        at = {**ship, **law.parameters(), "psi": self.psi, "t": float(t), "dt": float(ORDERS), "current": 0.0}
        at |= {"rudder_limit": gear.limit, "rudder_rate": gear.rate, "water": lambda name, x: np.zeros(np.shape(x))}
        memory = self._memory or law.memory(at)
        orders, after = law.orders(SimpleNamespace(**{**at, **memory}))
        hands = ~(self.upset & (t >= self.when) & (t < self.when + self.away))
        self.order = np.where(hands, orders["rudder"], self.order)
        self._memory = {name: np.where(hands, value, memory[name]) for name, value in after.items()}

    def _load(self, t: int) -> None:
        sailing, inputs, blows = self._sailing, self._inputs, (t >= self.blows) & (t < self.blows + GUST)
        acts = self.upset & (t >= self.when) & (t < self.when + self.lasts)
        strength = self.strength + self.size * acts
        banks = {name: strength * self.coefficients[name] for name in self.banks}
        columns = {PARAMETER("order"): self.order, "Y_in": self.gust * blows, "N_in": LEVER * self.gust * blows}
        columns |= self._constants({**self._values, **self.coefficients, **banks})
        for name, column in columns.items():
            if name in inputs:
                sailing.vessel_inputs[:, inputs[name]] = column
        for place, name in enumerate(sailing.kernel.KEPT_NAMES):
            sailing.start[:, place] = self.state.get(name, 0.0)


@cache
def _held_lines() -> dict[float, HeldLine]:
    return {y: nw.control.regulator(modelled(), float(y), SPEED).lines[0] for y in LINES.tolist()}


def helm(lines: np.ndarray) -> Regulator:
    """People who steer: the regulator as it is made for the ship as modelled, an order now and then."""
    known = _held_lines()
    held = [known[y] for y in lines.tolist()]
    numbers = {name: np.array([getattr(one, name) for one in held]) for name in ("y", "rudder", "psi", "v")}
    gains, turning = (np.array([getattr(one, name) for one in held]).T for name in ("gains", "turning"))
    line = HeldLine(gains=tuple(gains), turning=tuple(turning), **numbers)
    made = nw.control.regulator(modelled(), 0.0, SPEED)
    return Regulator((line,), SPEED, made.lead, made.unwinding)
