"""All futures of all samples in one call of the package's kernel: every one a lane, laid out once."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.codegen.choices import CURRENT_ACROSS, stages_at
from narrows.simulation.inputs import INPUTS, START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import CURRENT, PARAMETER, SimulatedShip, steering_of
from narrows.warning.forecasting.helmsman import REVOLUTIONS, LineOfSight, Manoeuvre, escape_numbers
from narrows.warning.settings import CONTACT_TOLERANCE

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

RUDDER = "rudder"
# Flow [1] of a waterway below which an estimated current gives no information on that elsewhere: the tide turns there.
LEAST_FLOW = 0.1
# Outcomes of a lane in a bank, or across the canal, which is on the way there.
MEETS = (Code.GROUNDED, Code.DIVERGED, Code.OUTSIDE)
NEVER = 1e9


class Case(NamedTuple):
    """One future: the rudder as it is until a time, then a manoeuvre, or the helmsman's own steering."""

    duration: float  # Length of the forecast [s]
    since: float = NEVER  # When the rudder is taken over [s]
    manoeuvre: Manoeuvre | None = None  # None: the helmsman steers as in the last minutes
    ordered: float | None = None  # Rudder until then [rad]; None: as it is


class FutureBlock(NamedTuple):
    cases: Sequence[Case]  # Each of every ship
    ships: int  # Number of ships

    @property
    def lanes(self) -> int:
        return len(self.cases) * self.ships


class Ships(NamedTuple):
    columns: Mapping[str, np.ndarray]  # (ships,) x, y [m], psi [rad], u, v [m/s], r [rad/s]
    rudder: np.ndarray  # (ships,) Its true angle [rad]
    coefficients: Mapping[str, np.ndarray]  # (ships,) By name, those of the bank as strong as it is estimated
    helmsman: Mapping[str, np.ndarray]  # (ships,) Numbers of the law by which the helmsman steers


class Outcomes(NamedTuple):
    contact: np.ndarray  # (cases, ships) When a bank is met; infinite where none is [s]
    side: np.ndarray  # (cases, ships) Which: negative to port, positive to starboard


class FutureLanes:
    """Lanes of one kind of ship in many futures."""

    def __init__(
        self, ship: SimulatedShip, waterway: "Waterway | None", line: float, blocks: Sequence[FutureBlock], step: float
    ) -> None:
        self.ship, self.waterway, self.blocks, self.line = ship, waterway, blocks, line
        self._driven = any(actuator.name == REVOLUTIONS for actuator in ship.actuators)
        steering = steering_of(LineOfSight(self._driven), ship.actuators)
        assert steering is not None
        lanes = sum(block.lanes for block in blocks)
        duration = np.concatenate([np.repeat([case.duration for case in b.cases], b.ships) for b in blocks])
        run = KernelRun(ship, duration, step, steering=steering, waterway=waterway)
        many = {name: np.full(lanes, value) for name, value in ship.model.coefficients.items()}
        many |= {name: np.full(lanes, value) for name, value in steering.parameters.items()}
        still = dict.fromkeys((*START, *INPUTS, CURRENT_ACROSS), 0.0)
        self._prepared = run.prepared({**still, "u": 1.0, **many}, lanes, workers=1)
        self._prepared.limits[0] = CONTACT_TOLERANCE * ship.model.configuration.ship.beam
        self._constants = ship.system(waterway is not None, steering.law).constants
        self._ship_values = ship.values()
        kernel = self._prepared.kernel
        self._kept = {name: place for place, name in enumerate(kernel.KEPT_NAMES)}
        self._inputs = {name: place for place, name in enumerate(kernel.VESSEL_INPUTS)}

    def __call__(self, ships: Sequence[Ships], revolutions: float | None = None) -> list[Outcomes]:
        for lanes, block, own in zip(self._parts(), self.blocks, ships, strict=True):
            self._load(lanes, block, own, revolutions)
        self._prepared()
        return self._ends()

    def _parts(self) -> list[slice]:
        stops = np.cumsum([block.lanes for block in self.blocks]).tolist()
        return [slice(stop - block.lanes, stop) for stop, block in zip(stops, self.blocks, strict=True)]

    def _load(self, lanes: slice, block: FutureBlock, ships: Ships, revolutions: float | None) -> None:
        shape, columns = (len(block.cases), block.ships, -1), ships.columns
        rows = self._prepared.start[lanes].reshape(shape)
        inputs = self._prepared.vessel_inputs[lanes].reshape(shape)
        own: dict[str, Any] = {name: columns[name] for name in ("x", "y", "u", "v", "r")}
        own |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"]), RUDDER: ships.rudder}
        turns = self._ship_values.get(REVOLUTIONS, 0.0) if revolutions is None else revolutions
        own |= {REVOLUTIONS: np.full(block.ships, turns)} if self._driven else {}
        # Orders that are on their way in a gear with dead time or lag: those of the rudder as it is.
        own |= stages_at(self.ship.actuators, own.__getitem__)
        for name, column in own.items():
            if name in self._kept:
                rows[..., self._kept[name]] = column
        constants = self._constants({**self._ship_values, **ships.coefficients})
        for name, column in {**constants, **self._currents(columns)}.items():
            if name in self._inputs:
                inputs[..., self._inputs[name]] = column
        for part, case in zip(inputs, block.cases, strict=True):
            for name, value in self._law(case, ships, turns).items():
                part[:, self._inputs[PARAMETER(name)]] = value

    def _currents(self, columns: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """Return the current along the line where its flow is 1, and that across."""
        currents = {CURRENT_ACROSS: columns.get(CURRENT_ACROSS, 0.0)}
        if self.waterway is None:
            return currents
        usual, flow = self.waterway.reference_current, self.waterway.flow(columns["x"])
        if CURRENT not in columns:
            return {**currents, CURRENT: usual}
        known = np.abs(flow) >= LEAST_FLOW
        return {**currents, CURRENT: np.where(known, columns[CURRENT] / np.where(known, flow, 1.0), usual)}

    def _law(self, case: Case, ships: Ships, turns: float) -> dict[str, Any]:
        hull, gear = self.ship.model.configuration.ship, self.ship.model.configuration.gear
        ordered = ships.rudder if case.ordered is None else case.ordered
        numbers: dict[str, Any] = {"since": case.since, "ordered": ordered}
        if case.manoeuvre is None:
            numbers |= {"approach": 10.0, "crab": 0.0, **ships.helmsman}
            numbers["since"] = np.maximum(numbers["since"], case.since)
        else:
            u = np.maximum(ships.columns["u"], 0.1)
            numbers |= escape_numbers(self.line, hull.length, gear.limit)
            numbers |= {"by_r": numbers["by_r"] / u, "crab": ships.columns.get(CURRENT_ACROSS, 0.0) / u}
        if self._driven:
            kick = case.manoeuvre.kick if case.manoeuvre else 1.0
            numbers |= {"turns": turns, "kicked": kick * turns}
        return numbers

    def poses(self) -> list[np.ndarray]:
        """Return where the futures of each block ended, after a call: x, y [m], psi [rad] (cases, ships, 3)."""
        end, kept = self._prepared.end, self._kept
        psi = np.arctan2(end[:, kept["sin_psi"]], end[:, kept["cos_psi"]])
        poses = np.stack([end[:, kept["x"]], end[:, kept["y"]], psi], axis=1)
        parts = zip(self._parts(), self.blocks, strict=True)
        return [poses[lanes].reshape(len(block.cases), block.ships, 3) for lanes, block in parts]

    def _ends(self) -> list[Outcomes]:
        codes, time = self._prepared.codes, self._prepared.time
        contact = np.where(np.isin(codes[:, 0], MEETS), time, np.inf)
        ends = []
        for lanes, block in zip(self._parts(), self.blocks, strict=True):
            shape = len(block.cases), block.ships
            ends.append(Outcomes(contact[lanes].reshape(shape), codes[lanes, 1].reshape(shape)))
        return ends
