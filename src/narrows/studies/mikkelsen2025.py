"""Reproduction of Mikkelsen et al. (2025): tests, coefficients, shares, voyages, switch, and the printed numbers."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

import narrows as nw
from narrows.base.results import BaseResult

SHARES = (
    *(0.0, 0.0, 1.0),
    *(0.239, 0.002, 0.087, 0.243, 0.132, 0.015, 0.283),
    *(0.040, 0.255, 0.235, 0.128, 0.026, 0.248, 0.069),
)
# Table (significance_test) of the paper: surge, sway and yaw.
PRINTED_SHARES = dict(zip(nw.published("mikkelsen2025_dtc").terms.names, SHARES, strict=True))
# Start [m] beyond which the paper's ship grounds on the near bank, "approximately".
PRINTED_SWITCH = 2.0
# The paper's constant surge force [N]; and an assumed mass in surge [kg], which the paper lacks: it is near that of
# straight runs of the same hull, and has no effect at the speed where force and resistance balance.
SURGE_FORCE, SURGE_MASS = 12.6, 300.0
# Displacement of the model [kg] at its scale, for the reading with Coriolis.
MASS = 245.0
# Longest duration of a voyage [s].
DURATION = 120.0
STARTS = np.linspace(0.1, 2.5, 241)
SHOWN_STARTS = (0.1, 0.5, 0.9, 1.3, 1.7, 2.1, 2.5)


@dataclass(frozen=True, repr=False)
class Reproduction(BaseResult):
    """The paper's coefficients as the truth: identification from tests of its kinds, and voyages of its ship."""

    truth: nw.Model  # The model as printed
    fit: nw.Fit  # Fit to synthetic tests of the paper's kinds
    voyages: dict[float, nw.Voyage]  # Voyages by start to starboard [m], contact by the hull's corners
    readings: dict[str, Any]  # Voyages from ``STARTS`` under each reading of contact, with a Coriolis term and without

    def to_dataframe(self) -> pd.DataFrame:
        """Return the coefficients as a table: one row each, as printed and as identified again."""
        return pd.DataFrame([self._coefficient(name) for name in self.truth.terms.names]).set_index("name")

    @property
    def notes(self) -> tuple[str, ...]:
        """Coefficients that tests of this kind do not determine."""
        return tuple(v.sentence(name) for name, v in self.fit.verdicts.items() if v.status != "identified")

    @cached_property
    def switches(self) -> dict[str, float | None]:
        """The start beyond which the ship grounds on the near bank [m], by reading; None if there is none."""
        return {name: switch_of(voyages) for name, voyages in self.readings.items()}

    @cached_property
    def shares(self) -> dict[str, float]:
        """The Shapley share of each coefficient in its own force."""
        return {name: share for part in self.fit.shapley().values() for name, share in part.items()}

    @cached_property
    def modes(self) -> dict[str, np.ndarray]:
        """Eigenvalues at 1 m/s on the centreline [1/s]."""
        banks = {"with the bank": True, "without": False}
        found = {name: nw.stability(self.truth, bank, u=1.0)["eigenvalue"] for name, bank in banks.items()}
        return {name: eigenvalues.to_numpy().ravel() for name, eigenvalues in found.items()}

    @property
    def stiffness(self) -> float:
        """Slope of the pressure difference across the centreline [1/m], 8 B W / (W - B)^3: of eq. (Delta_1)."""
        beam, width = self.truth.ship.beam, self.truth.canal.width
        return 8 * beam * width / (width - beam) ** 3

    def summary(self) -> str:
        where = {name: "nowhere" if y is None else f"from y(0) = {y:.2f} m" for name, y in self.switches.items()}
        return "\n".join(f"grounds on the near bank {at}: {name}" for name, at in where.items())

    def to_dict(self) -> dict[str, Any]:
        return {
            "coefficients": [self._coefficient(name) for name in self.truth.terms.names],
            "shapley": [{"name": n, "printed": PRINTED_SHARES[n], "ours": ours} for n, ours in self.shares.items()],
            "readings": [{"name": name, "switch": switch} for name, switch in self.switches.items()],
            "printed_switch": PRINTED_SWITCH,
            "eigenvalues": {name: [[z.real, z.imag] for z in ours] for name, ours in self.modes.items()},
            "stiffness": self.stiffness,
            "summary": self.summary(),
            "notes": self.notes,
        }

    def _coefficient(self, name: str) -> dict[str, Any]:
        verdict, known = self.fit.verdicts[name], self.fit.verdicts[name].determined
        return {
            "name": name,
            "printed": self.truth.coefficients[name],
            "value": self.fit.coefficients[name] if known else None,
            "ci95": self.fit.intervals[name] if known else None,
            "verdict": verdict.status,
        }


def reproduce(progress: Callable[[str], None] = lambda _: None) -> Reproduction:
    """Run the paper's tests on its own coefficients, identify them, and simulate its voyages."""
    # Mikkelsen, Enevoldsen, Jensen, Jeppesen, Galeazzi, Papageorgiou (2025), Closed form modelling and identification
    # of banking effects in confined waters.
    truth = nw.published("mikkelsen2025_dtc")
    progress("synthetic tests and their identification")
    fit = nw.identify(nw.twin(truth), balance="rows")
    progress("voyages and grounding distances")
    # As the paper: 1 m/s, a constant surge force, free speed (with an assumed mass in surge)
    common: dict[str, Any] = {"duration": DURATION, "surge": "free", "surge_inertia": SURGE_MASS, "X": SURGE_FORCE}
    voyages = {y: nw.simulate(truth, y, 1.0, **common) for y in SHOWN_STARTS}
    ship = replace(truth.configuration.ship, mass=MASS)
    heavy = replace(truth, configuration=replace(truth.configuration, ship=ship))
    common["y"] = STARTS
    readings = {
        "hull corners": nw.ensemble(truth, **common),
        "midship clearance": nw.ensemble(truth, contact="midship", **common),
        "hull corners, with Coriolis": nw.ensemble(heavy, coriolis=True, **common),
        "midship clearance, with Coriolis": nw.ensemble(heavy, coriolis=True, contact="midship", **common),
    }
    return Reproduction(truth, fit, voyages, readings)


def switch_of(voyages: Any) -> float | None:
    """Return the smallest start beyond which every ship grounds to starboard [m], None if there is none."""
    elsewhere = np.flatnonzero(voyages["side"].to_numpy() <= 0)
    first = int(elsewhere[-1]) + 1 if elsewhere.size else 0
    return float(voyages["y"][first]) if first < voyages.sizes["y"] else None
