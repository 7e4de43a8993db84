"""The kernel of a fleet under autopilots: each vessel's own loop, an order to her rudder at each step.

A rudder that has reached its limit of angle or rate makes the motion a chain of branches, so vessels are not stepped in
lanes here; what they share with the other kernels is the right-hand side.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from narrows.compile.emit import Emitted
from narrows.compile.exponential import exponential_text
from narrows.compile.fleet import on_all_cores
from narrows.compile.kernel import HEADER, LARGER
from narrows.compile.spell import BLOCK


def helmed_text(emitted: Emitted, version: str) -> str:
    """Write the module that sails a fleet under autopilots.

    Parameters
    ----------
    emitted : Emitted
        The equations, with inputs and controls as arguments.
    version : str
        Of narrows.
    """
    functions = "\n\n".join(f"@jit\n{emitted.function(name, BLOCK)}" for name in ("rhs", "gap", "lean"))
    own = ", ".join(f"constants[vessel, {number}]" for number in range(len(emitted.constants.names)))
    helpers = [exponential_text("float64")] if "exp(" in functions else []
    helpers += [LARGER] if "larger(" in functions else []
    return "\n\n".join(
        [
            HEADER.format(version=version, precision="float64", lanes=1, fields=0),
            emitted.prologue(),
            *helpers,
            functions,
            f"@jit\ndef of_vessel(constants, vessel):\n    return ({own},)\n",
            (Path(__file__).parent / "wheel.py").read_text(encoding="utf-8"),
        ]
    )


@dataclass(frozen=True)
class Helmed:
    """How a fleet under autopilots fared.

    Parameters
    ----------
    outcome : array (n,) of int
        An ``Outcome``.
    farthest : array (n,) [m]
        Largest distance from the offset to hold.
    late : array (n,) [m]
        The same over the last steps.
    rudder : array (n,) [rad]
        Largest angle.
    """

    outcome: np.ndarray
    farthest: np.ndarray
    late: np.ndarray
    rudder: np.ndarray


PILOT = (
    "hold_y", "hold_psi", "hold_v", "hold_rudder", "by_y", "by_psi", "by_v", "by_r",
    "limit", "rate", "revolutions", "push_Y", "push_N", "push_time",
    "wall_port", "wall_starboard", "half_length", "half_beam", "late",
)  # fmt: skip
"""What is known of each helm: what to hold, the rudder for each thing off, the gear, a push with its time, where a keel
meets the banks and the hull that does, and how many steps count as the end."""


def sail_helmed(
    kernel: ModuleType, constants: Callable[[slice], np.ndarray], start: np.ndarray, steps: np.ndarray,
    pace: np.ndarray, pilots: np.ndarray, limits: np.ndarray, workers: int | None,
) -> Helmed:  # fmt: skip
    """Sail a fleet under autopilots on several cores; what comes out does not depend on how many (ours).

    Parameters
    ----------
    kernel : module
        The generated kernel.
    constants : callable
        Gives those of some vessels.
    start : array (n, 7)
        The state at the start, as ``STATE`` orders it.
    steps : array (n,)
        Most steps of each vessel.
    pace : array (n,) [s]
        The time step of each vessel.
    pilots : array (n, 19)
        As ``PILOT`` orders it.
    limits : array
        What else ends a voyage.
    workers : int, optional
        Threads; a core each if absent.
    """
    kept, codes = np.empty((len(pace), 3)), np.empty(len(pace), np.int8)

    def run(rows: slice) -> None:
        kernel.helmed(
            start[rows], pace[rows], steps[rows], pilots[rows], constants(rows), limits, kept[rows], codes[rows]
        )

    on_all_cores(run, len(pace), workers)
    return Helmed(codes, *kept.T)
