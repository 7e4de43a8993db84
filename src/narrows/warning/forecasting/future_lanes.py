"""All futures of all members in one call of the package's kernel: every one a lane, laid out once."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from narrows.codegen.run import PreparedRun, step_counts
from narrows.control.regulator_law import Regulator
from narrows.estimation.bank_strength import by_bank
from narrows.estimation.ship_lanes import RUDDER
from narrows.simulation.inputs import INPUTS, START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import PARAMETER, steering_of
from narrows.warning.forecasting.forecast_cases import Case
from narrows.warning.forecasting.takeover_law import HELD, TAKEN_OVER, TakeoverLaw

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

MEETS = (Code.GROUNDED, Code.DIVERGED, Code.OUTSIDE)
"""How a lane ends in a bank, or across the canal, which is on the way there."""


TOLERANCE = 0.02
"""Of the beam: how closely a contact is located."""


class FutureBlock(NamedTuple):
    """Futures of some ships.

    Parameters
    ----------
    cases : sequence of Case
        Each of every ship.
    coefficients : array (ships, coefficients)
        Of each.
    """

    cases: Sequence[Case]
    coefficients: np.ndarray

    def repeated(self, name: str) -> np.ndarray:
        """Return a number of the cases for every lane.

        Parameters
        ----------
        name : str
            Of it.
        """
        return np.repeat([getattr(case, name) for case in self.cases], len(self.coefficients))


class Ships(NamedTuple):
    """States from which the futures of a block begin.

    Parameters
    ----------
    columns : dict of str to array (ships,)
        x, y [m], psi [rad], u, v [m/s], r [rad/s], and the bank's strength.
    rudder : array (ships,) [rad]
        Its true angle.
    """

    columns: Mapping[str, np.ndarray]
    rudder: np.ndarray


class Ends(NamedTuple):
    """How the futures of a block end.

    Parameters
    ----------
    contact : array (cases, ships) [s]
        When a bank is met; infinite where none is.
    side : array (cases, ships)
        Which: negative to port, positive to starboard.
    """

    contact: np.ndarray
    side: np.ndarray


class FutureLanes:
    """Lanes of one ship in many futures.

    Parameters
    ----------
    ship : SimulatedShip
        The ship.
    waterway : Waterway, optional
        Where it sails instead of the model's own canal.
    pilot : Regulator
        Who takes over.
    blocks : sequence of FutureBlock
        Laid out one after the other.
    step : float [s]
        Of the motion.

    Raises
    ------
    InputError
        Where the model's terms make the bank's strength more than a factor.
    """

    def __init__(
        self,
        ship: SimulatedShip,
        waterway: "Waterway | None",
        pilot: Regulator,
        blocks: Sequence[FutureBlock],
        step: float,
    ) -> None:
        self.ship, self.blocks, self._gear = ship, blocks, ship.model.configuration.gear
        self._taken_over, self._duration, self._hard_over = (
            np.concatenate([block.repeated(name) for block in blocks])
            for name in ("taken_over", "duration", "hard_over")
        )
        self._lanes = len(self._duration)
        law = TakeoverLaw(pilot, np.zeros(self._lanes), self._taken_over)
        steering = steering_of(law, ship.actuators)
        self._run = KernelRun(ship, self._duration, step, steering=steering, waterway=waterway)
        self._step, self._base, self._slope = step, *by_bank(lambda bank: self._laid_out(bank).vessel_inputs)
        self._prepared = self._laid_out(1.0)
        self._prepared.limits[0] = TOLERANCE * ship.model.configuration.ship.beam
        kernel = self._prepared.kernel
        self._kept = {name: place for place, name in enumerate(kernel.KEPT_NAMES)}
        self._inputs = {name: place for place, name in enumerate(kernel.VESSEL_INPUTS)}
        self.steer(pilot)

    def _laid_out(self, bank: float) -> PreparedRun:
        model = self.ship.model
        columns = np.concatenate([np.tile(block.coefficients, (len(block.cases), 1)) for block in self.blocks]).T
        numbers = dict(zip(model.terms.names, columns, strict=True))
        numbers |= {term.name: bank * numbers[term.name] for term in model.terms.terms if term.from_bank}
        law = {PARAMETER(TAKEN_OVER): self._taken_over, PARAMETER(HELD): np.zeros(self._lanes)}
        still = dict.fromkeys((*START, *INPUTS), 0.0)
        return self._run.prepared({**still, "u": 1.0, **numbers, **law}, self._lanes, workers=1)

    def steer(self, pilot: Regulator) -> None:
        """Let another pilot of the same kind take over.

        Parameters
        ----------
        pilot : Regulator
            Of one line.
        """
        for name, value in pilot.parameters().items():
            place = self._inputs.get(PARAMETER(name))
            if place is not None:
                self._base[:, place] = value

    def flow(self, current: float, revolutions: float | None) -> None:
        """Take the current along the waterway and the propeller's revolutions as they are now.

        Parameters
        ----------
        current : float [m/s]
            Along it.
        revolutions : float, optional [1/s]
            Of the propeller.
        """
        names, shared = self._prepared.kernel.SHARED, self._prepared.shared
        for name, value in (("current", current), ("revolutions", revolutions)):
            if name in names and value is not None:
                shared[names.index(name)] = value

    def __call__(self, ships: Sequence[Ships]) -> list[Ends]:
        """Return how the futures end.

        Parameters
        ----------
        ships : sequence of Ships
            Of each block.
        """
        first = 0
        np.copyto(self._prepared.times, step_counts(np.full(self._lanes, self._step), self._duration))
        for block, own in zip(self.blocks, ships, strict=True):
            last = first + len(block.cases) * len(block.coefficients)
            self._load(slice(first, last), len(block.cases), own)
            first = last
        self._prepared()
        return self._ends()

    def _load(self, lanes: slice, cases: int, ships: Ships) -> None:
        columns, rows, inputs = ships.columns, self._prepared.start[lanes], self._prepared.vessel_inputs[lanes]
        own = {name: columns[name] for name in ("x", "y", "u", "v", "r")}
        own |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"]), RUDDER: ships.rudder}
        for name, column in own.items():
            rows[:, self._kept[name]] = np.tile(column, cases)
        np.multiply(np.tile(columns["bank"], cases)[:, None], self._slope[lanes], out=inputs)
        inputs += self._base[lanes]
        side = self._hard_over[lanes]
        inputs[:, self._inputs[PARAMETER(HELD)]] = np.where(side, side * self._gear.limit, np.tile(ships.rudder, cases))

    def _ends(self) -> list[Ends]:
        codes, time = self._prepared.codes, self._prepared.time
        contact = np.where(np.isin(codes[:, 0], MEETS), time, np.inf)
        ends, first = [], 0
        for block in self.blocks:
            shape = len(block.cases), len(block.coefficients)
            part = slice(first, first + shape[0] * shape[1])
            ends.append(Ends(contact[part].reshape(shape), codes[part, 1].reshape(shape)))
            first = part.stop
        return ends
