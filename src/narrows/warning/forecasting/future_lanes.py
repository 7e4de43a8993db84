"""All futures of all members in one call of the package's kernel: every one a lane, laid out once."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from narrows.control.regulator_law import Regulator
from narrows.estimation.ship_lanes import RUDDER
from narrows.simulation.controllers import LAST_ORDER, ORDERED, SwitchedLaw
from narrows.simulation.inputs import INPUTS, START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import MEMORY, PARAMETER, steering_of
from narrows.warning.forecasting.forecast import AFTER, AS_IS, NEVER, Case
from narrows.warning.settings import CONTACT_TOLERANCE

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# How a lane ends in a bank, or across the canal, which is on the way there.
MEETS = (Code.GROUNDED, Code.DIVERGED, Code.OUTSIDE)


class FutureBlock(NamedTuple):
    cases: Sequence[Case]  # Each of every ship
    ships: int  # How many

    @property
    def lanes(self) -> int:
        return len(self.cases) * self.ships

    def repeated(self, name: str) -> np.ndarray:
        """Return a number of the cases for every lane."""
        return np.repeat([getattr(case, name) for case in self.cases], self.ships)


class Ships(NamedTuple):
    columns: Mapping[str, np.ndarray]  # (ships,) x, y [m], psi [rad], u, v [m/s], r [rad/s]
    rudder: np.ndarray  # (ships,) Its true angle [rad]
    coefficients: Mapping[str, np.ndarray]  # (ships,) By name, those of the bank as strong as it is estimated


class Outcomes(NamedTuple):
    contact: np.ndarray  # (cases, ships) When a bank is met; infinite where none is [s]
    side: np.ndarray  # (cases, ships) Which: negative to port, positive to starboard


class FutureLanes:
    """Lanes of one ship in many futures."""

    def __init__(
        self, ship: SimulatedShip, waterway: "Waterway | None", pilot: Regulator, blocks: Sequence[FutureBlock],
        step: float,
    ) -> None:  # fmt: skip
        self.ship, self.blocks, self._gear = ship, blocks, ship.model.configuration.gear
        self._taken_over, self._duration, self._hard_over = (
            np.concatenate([block.repeated(name) for block in blocks])
            for name in ("taken_over", "duration", "hard_over")
        )
        self._lanes = len(self._duration)
        law = SwitchedLaw(pilot, np.zeros(self._lanes), self._taken_over)
        steering = steering_of(law, ship.actuators)
        run = KernelRun(ship, self._duration, step, steering=steering, waterway=waterway)
        many = {name: np.full(self._lanes, value) for name, value in ship.model.coefficients.items()}
        still = dict.fromkeys((*START, *INPUTS), 0.0)
        self._prepared = run.prepared({**still, "u": 1.0, **many}, self._lanes, workers=1)
        self._prepared.limits[0] = CONTACT_TOLERANCE * ship.model.configuration.ship.beam
        self._constants = ship.system(waterway is not None, steering.law if steering else None).constants
        self._ship_values = ship.values()
        kernel = self._prepared.kernel
        self._kept = {name: place for place, name in enumerate(kernel.KEPT_NAMES)}
        self._inputs = {name: place for place, name in enumerate(kernel.VESSEL_INPUTS)}

    def steer(self, pilot: Regulator) -> None:
        for name, value in pilot.parameters().items():
            place = self._inputs.get(PARAMETER(name))
            if place is not None:
                self._prepared.vessel_inputs[:, place] = value

    def flow(self, current: float, revolutions: float | None) -> None:
        for name, value in (("current", current), ("revolutions", revolutions)):
            if name in self._inputs and value is not None:
                self._prepared.vessel_inputs[:, self._inputs[name]] = value

    def __call__(self, ships: Sequence[Ships]) -> list[Outcomes]:
        for lanes, block, own in zip(self._parts(), self.blocks, ships, strict=True):
            self._load(lanes, len(block.cases), own)
        self._prepared()
        return self._ends()

    def _parts(self) -> list[slice]:
        stops = np.cumsum([block.lanes for block in self.blocks]).tolist()
        return [slice(stop - block.lanes, stop) for stop, block in zip(stops, self.blocks, strict=True)]

    def _load(self, lanes: slice, cases: int, ships: Ships) -> None:
        columns, rows, inputs = ships.columns, self._prepared.start[lanes], self._prepared.vessel_inputs[lanes]
        own = {name: columns[name] for name in ("x", "y", "u", "v", "r")}
        own |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
        own |= dict.fromkeys((RUDDER, MEMORY(LAST_ORDER)), ships.rudder)
        for name, column in own.items():
            rows[:, self._kept[name]] = np.tile(column, cases)
        for name, column in self._constants({**self._ship_values, **ships.coefficients}).items():
            if name in self._inputs:
                inputs[:, self._inputs[name]] = np.tile(np.broadcast_to(column, len(ships.rudder)), cases)
        side, held = self._hard_over[lanes], np.tile(ships.rudder, cases)
        inputs[:, self._inputs[PARAMETER(ORDERED)]] = np.where(side, side * self._gear.limit, held)

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


# Where a ship may go: places of the members time after time, to be drawn and not to be warned by.
# Between the places of a track [s].
EVERY = 10.0
TIMES = tuple(np.arange(EVERY, AFTER + EVERY / 2, EVERY).tolist())
# Whose tracks are drawn.
FAN_MEMBERS = 32
AS_IT_IS = tuple(Case(f"{AS_IS} for {t:g} s", NEVER, t) for t in TIMES)
WITH_PILOT = tuple(Case(f"pilot for {t:g} s", 0.0, t) for t in TIMES)
# A lane for every place of a track: it ends there.
BLOCKS = FutureBlock(AS_IT_IS, FAN_MEMBERS), FutureBlock(AS_IT_IS, 1), FutureBlock(WITH_PILOT, 1)


class PredictedFan(NamedTuple):
    """Tracks, each pose of them along the waterway and off its line [m] and the heading to it [rad]."""

    times: np.ndarray  # (times,) From now on [s]
    members: np.ndarray  # (members, times, 3) Samples, the rudder as it is; after contact a sample stays
    likely: np.ndarray  # (times, 3) Of the most likely one
    pilot: np.ndarray  # (times, 3) Of the same with a pilot who takes over now


def fan_of(poses: list[np.ndarray]) -> PredictedFan:
    """Return the tracks of lanes laid out by ``BLOCKS``, from poses (times, ships, 3)."""
    members, likely, pilot = poses
    return PredictedFan(np.array(TIMES), members.swapaxes(0, 1), likely[:, 0], pilot[:, 0])
