"""From a table of terms to equations of motion that run fast: traced once, cached, differentiated exactly.

    program = compiled(model.terms)
    values = {**model.configuration.values(), **model.coefficients}
    fleet = program.fleet(values, y=y, u=1.0, dt=0.02, duration=40.0)

``record`` writes down what the regressors do, ``trace`` solves for the accelerations in symbols, ``emit`` and
``spell`` write straight-line functions, ``kernel`` and ``lanes`` the loop that Numba compiles, ``cache`` keeps all of
it on disk, and ``program`` is the door to it.
"""

from collections.abc import Sequence

from narrows.compile.contact import checked_shape
from narrows.compile.fleet import Fleet as Fleet
from narrows.compile.fleet import Limits as Limits
from narrows.compile.jacobian import LINEARISED as LINEARISED
from narrows.compile.jacobian import Linearisation as Linearisation
from narrows.compile.outcome import Outcome as Outcome
from narrows.compile.program import Program as Program
from narrows.compile.trace import STATE as STATE
from narrows.compile.trace import Surge
from narrows.errors import InputError
from narrows.terms.term import TermTable


def compiled(
    table: TermTable,
    surge: Surge = "held",
    coriolis: bool = False,
    contact: str | Sequence[tuple[float, float]] = "corners",
) -> Program:
    """Compile a table of terms, a user's own included.

    Parameters
    ----------
    table : TermTable
        Terms whose regressors are written with arithmetic and ``abs()`` alone.
    surge : {"held", "free"}
        Hold the surge velocity, or let it follow its own equation; then ``surge_inertia`` [kg] among the values is
        added to the table's own mass in surge.
    coriolis : bool
        Add -m u r in sway and m v r in surge. A fit at one speed holds them already: leave it off unless the terms
        were identified without.
    contact : str or sequence of pairs of float [m]
        What of the hull meets a bank: the ``corners`` of its rectangle; points (forward, starboard) of its outline;
        or its side at ``midship``, the paper's clearance. There the suction grows without end, so that contact is
        where the motion runs away within a thousandth of the width.

    Raises
    ------
    InputError
        Where the contact is unknown; where a regressor does more than arithmetic, when the program is first used.
    """
    if surge not in ("held", "free"):
        raise InputError(f"surge {surge!r} is unknown; it is 'held' or 'free'")
    return Program(table, surge, coriolis, checked_shape(contact))
