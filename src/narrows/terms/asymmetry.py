"""The force and moment of a ship whose port and starboard sides differ: propeller, rudder zero, hull."""

from narrows.errors import InputError
from narrows.physics.hull import HullPower
from narrows.quantities.dimensions import NUMBER
from narrows.terms.term import Term, TermKind, TermTable

# What the name of a table says where it has these terms.
WITH_ASYMMETRY = "asymmetry"
SOURCE = "Y_0' and N_0' of polynomial manoeuvring models, as in Abkowitz (1964)"


def asymmetry_names(table: TermTable) -> tuple[str, str]:
    """Return what a table calls the coefficients of the sway force and of the yaw moment."""
    _, sway, yaw = table.letters
    return f"{sway}_0", f"{yaw}_0"


def with_asymmetry(table: TermTable) -> TermTable:
    """Return a table with a constant sway force and yaw moment, which grow with the speed squared."""
    sway, yaw = asymmetry_names(table)
    if sway in table.names:
        raise InputError(f"the terms {table.name!r} have an asymmetry; leave +{WITH_ASYMMETRY} out")
    return table.with_terms(
        f"{table.name}+{WITH_ASYMMETRY}",
        sway=[Term(sway, f"{sway}'", HullPower(0, 0), NUMBER, kind=TermKind.HULL, source=SOURCE)],
        yaw=[Term(yaw, f"{yaw}'", HullPower(0, 0, lever=1), NUMBER, kind=TermKind.HULL, source=SOURCE)],
    )
