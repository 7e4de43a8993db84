"""Many voyages by columns of NumPy: where there is no compiler, as in a browser, what a kernel does elsewhere."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import numpy as np

from narrows.codegen.choices import LENGTH, SHARE
from narrows.codegen.kernels import event
from narrows.codegen.system import System
from narrows.simulation.channel import Channel
from narrows.simulation.march import CONTACT_TOLERANCE, March, Row, near_the_bank
from narrows.simulation.outcome import Code

COSINE = 2


def lacks_compiler() -> bool:
    """Return whether Numba is not here, so that ships are sailed by columns."""
    try:
        return find_spec("numba") is None
    except ValueError:  # What stands for it is no module.
        return True


@dataclass
class ColumnRun:
    """Vessels laid out in columns; calling it sails them all, from ``start`` as it then stands."""

    # Every vessel takes its step at once; whichever met something or ran out of sane numbers in it has that step
    # judged alone, as in a single voyage.

    system: System  # Whose lines
    inputs: Mapping[str, Any]  # (n,) Everything that its step asks for, by name
    start: np.ndarray  # (n, kept) What is kept from step to step, at the start
    times: np.ndarray  # (n, 3) Length of a step, whole steps, length of the last and shorter one [s]
    channel: Channel  # Where they sail
    end: np.ndarray = field(init=False)
    time: np.ndarray = field(init=False)
    codes: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.end, self.time = self.start.copy(), np.zeros(len(self.start))
        self.codes = np.zeros((len(self.start), 2), np.int64)

    @property
    def kernel(self) -> SimpleNamespace:
        """What a caller asks of a kernel: what is kept."""
        return SimpleNamespace(KEPT_NAMES=self.system.choices.kept)

    def __call__(self) -> int:
        """Sail every vessel, and return the steps that it took."""
        self.end, self.time, taken = self.start.copy(), np.zeros(len(self.start)), 0
        under_way = np.arange(len(self.start))
        step, count, rest = self.times.T
        left, length = count + (rest > 0), step.copy()
        while len(under_way := under_way[left[under_way] > 0]):
            last = (left[under_way] == 1) & (rest[under_way] > 0)
            length[under_way[last]] = rest[under_way[last]]
            under_way = self._stepped(under_way, length[under_way])
            left[under_way] -= 1
            taken += len(under_way)
        return taken

    def _stepped(self, vessels: np.ndarray, length: np.ndarray) -> np.ndarray:
        """Take a step of some vessels, and return those that sail on."""
        functions, before = self.system.columns, self.end[vessels].T
        asked = {**self.inputs, LENGTH: length, SHARE: 1.0}
        inputs = [self._own(name, asked[name], vessels) for name in functions.STEP_INPUTS]
        table = self.channel.water.table
        with np.errstate(all="ignore"):
            *after, room, _ = functions.step(table, *before, *inputs)
            clear = self._clear(np.array([np.broadcast_to(one, len(vessels)) for one in after]), room, before, vessels)
        went = vessels[clear]
        self.end[went] = np.array([np.broadcast_to(one, len(vessels))[clear] for one in after]).T
        self.time[went] += length[clear]
        judged = [
            self._judged(vessel, duration) for vessel, duration in zip(vessels[~clear], length[~clear], strict=True)
        ]
        return np.sort(np.concatenate([went, vessels[~clear][np.array(judged, bool)]]))

    def _clear(self, after: np.ndarray, room: Any, before: np.ndarray, vessels: np.ndarray) -> np.ndarray:
        """Whether a step needs no judge."""
        u, v, r = after[4:7]
        fast, turning = self.inputs["most_speed"], self.inputs["most_rate"]
        left = np.asarray(room)
        if leaves := self.system.choices.leaves:
            functions = self.system.columns
            inputs = [self._own(name, self.inputs[name], vessels) for name in functions.ROOM_INPUTS]
            left = left - leaves * functions.room(self.channel.water.table, *before[:4], *inputs)[0]
        return np.asarray((np.abs(u) < fast) & (np.abs(v) < fast) & (np.abs(r) < turning) & (left > 0))

    @staticmethod
    def _own(name: str, value: Any, vessels: np.ndarray) -> Any:
        whole = np.asarray(value, float)
        if name == LENGTH or whole.size == 1:
            return whole if whole.ndim else float(whole)
        return whole[vessels]

    def _judged(self, vessel: int, length: float) -> bool:
        """Sail one step of one vessel as a voyage does, and return whether it sails on."""
        march = self._march(vessel)
        begun = tuple(self.end[vessel].tolist())
        room, lean = march.room(begun)
        if room <= 0 and begun[0] != self.channel.start:
            self._over(vessel, march, event.CLOSED, lean)
            return False
        rows = [Row(0.0, begun)]
        ended = march.sail(rows, length, length)
        self.end[vessel] = rows[-1].state
        self.time[vessel] += rows[-1].t
        if ended is not None:
            self._over(vessel, march, ended.fate, ended.lean)
        return ended is None

    def _march(self, vessel: int) -> March:
        one = np.array([vessel])
        inputs = {name: float(np.ravel(self._own(name, value, one))[0]) for name, value in self.inputs.items()
                  if isinstance(value, int | float | np.ndarray | np.number)}  # fmt: skip
        near = near_the_bank({"width": inputs.get("width", 1.0)})
        return March(self.system.scalar, self.system.choices, inputs, self.channel, near)

    def _over(self, vessel: int, march: March, fate: int, lean: float) -> None:
        code = self._code(self.end[vessel], march, fate)
        self.codes[vessel] = code, np.sign(lean) if code == Code.GROUNDED else 0

    def _code(self, state: np.ndarray, march: March, fate: int) -> int:
        if fate == event.LOST:
            return Code.DIVERGED
        near = 10 * CONTACT_TOLERANCE
        if state[COSINE] - march.inputs["least_cos"] <= near:
            return Code.OUTSIDE
        if self.channel.length - state[0] <= near:
            return Code.PASSED
        return Code.ASTERN if state[0] - self.channel.start <= near else Code.GROUNDED
