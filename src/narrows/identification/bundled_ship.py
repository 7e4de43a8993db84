"""A ship at full size from the tests that come with the package, for demonstrations."""

from narrows.captive.measured import measured_files
from narrows.captive.read import read_captive
from narrows.identification.conditions import identify_conditions
from narrows.model.froude import scale_model
from narrows.model.model import Model
from narrows.terms.tables import STEERED
from narrows.terms.term import TermTable

ROWS = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
# 50 % under the keel; of the water [kg/m3].
CONDITION, DENSITY = "C0101A02", 1025.0


def bundled_ship(length: float, width: float, depth: float | None = None, terms: TermTable = STEERED) -> Model:
    """Return the KCS as identified from the bundled tests, with its rudder, at another size."""
    # length [m]; width [m]; depth [m]
    table, ship = measured_files("kcs")
    fit = identify_conditions(read_captive(table, ship, ROWS), terms=terms)[CONDITION]
    return scale_model(fit.model, length, DENSITY, width=width, depth=depth).model
