"""The rudder's coefficients from the KCS tests with the rudder turned, and what these do not tell.

python decisions/rudder.py [--write]
"""

from dataclasses import replace

from pages import markdown, publish

import narrows as nw
from narrows.base.results import interval, readable
from narrows.captive.measured import measured_files

CLEARANCES = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
NAMES = ("a_helm", "b_helm", "c_helm")


def fits(straightening: float) -> dict[str, nw.Fit]:
    """Fit the steered table to harmonic, steady and swept-rudder tests at each depth."""
    table, ship = measured_files("kcs")
    configuration = nw.read_ship(ship)
    configuration = replace(configuration, ship=replace(configuration.ship, flow_straightening=straightening))
    return nw.identify_conditions(nw.read_captive(table, configuration, TURNED), terms=nw.STEERED)


def _with_interval(value: float, low: float, high: float) -> str:
    half = (high - low) / 2
    return f"{readable(value, half)} ({interval((low, high), half)})"


def text() -> str:
    """One row for each depth; then how much the error depends on the straightening."""
    rows = []
    for label, fit in fits(0.5).items():
        cells = (_with_interval(fit.coefficients[name], *fit.intervals[name]) for name in NAMES)
        lever = fit.coefficients["c_helm"] / fit.coefficients["b_helm"]
        rows.append((CLEARANCES[label], *cells, f"{lever:.2f} L"))
    low, high = (fits(share)["C0101A01"].left_out["N"].rmse for share in (0.2, 1.0))
    table = markdown(("clearance", *NAMES, "lever c_helm/b_helm"), rows)
    return (
        f"{table}\n\nA flow straightening of 1.0 instead of 0.2 changes the error of N on left-out tests by "
        f"{100 * (high / low - 1):+.1f} %: these tests do not determine it."
    )


if __name__ == "__main__":
    publish(__file__, "rudder.md", text())
