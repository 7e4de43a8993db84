"""The paper again: every table and figure of it, ours beside its own numbers, and why they differ where they do."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from narrows.captive.synthetic import twin
from narrows.identification import Fit, identify
from narrows.identification.shapley import KINDS
from narrows.model.model import Model
from narrows.model.model_file import published
from narrows.report.bank_figures import delta_figure, delta_surface_figure
from narrows.report.collinearity_figures import correlation_figure
from narrows.report.fit_figures import forces_figure, shapley_figure
from narrows.report.fit_page import figure, render
from narrows.report.motion_figures import tests_figure
from narrows.report.numbers import interval, readable
from narrows.report.voyage_figures import distances_figure, paths_figure
from narrows.simulation.fleets import ensemble
from narrows.simulation.maps import grounding_distance
from narrows.simulation.modes import bank_stiffness, eigenvalues
from narrows.simulation.voyage import Voyage, simulate
from narrows.terms.canal_tables import PAPER

SHARES = (
    *(0.0, 0.0, 1.0),
    *(0.239, 0.002, 0.087, 0.243, 0.132, 0.015, 0.283),
    *(0.040, 0.255, 0.235, 0.128, 0.026, 0.248, 0.069),
)
PRINTED_SHARES = dict(zip(PAPER.names, SHARES, strict=True))
"""Table (significance_test) of the paper, of surge, sway and yaw."""
PRINTED_SWITCH = 2.0
"""Start [m] beyond which the paper's ship grounds on the near bank, "approximately"."""
SURGE_FORCE, SURGE_MASS = 12.6, 300.0
"""The paper's constant surge force [N]; and a mass in surge [kg] for it to act on, which the paper does not have:
it is near what straight runs of the same hull give, and at the speed where force and resistance balance it
does not matter."""
MASS = 245.0
"""Displacement of the model [kg] at its scale, for the reading with Coriolis."""
STARTS = np.linspace(0.1, 2.5, 241)
SHOWN_STARTS = (0.1, 0.5, 0.9, 1.3, 1.7, 2.1, 2.5)


def write_reproduction(path: str | Path, progress: Callable[[str], None] = lambda _: None) -> dict[str, Any]:
    """Write the reproduction of the paper as one HTML file, and return its numbers.

    Parameters
    ----------
    path : str or Path
        Where to.
    progress : callable
        Told what is being done.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    from narrows.files import write_whole

    truth = published("mikkelsen2025_dtc")
    progress("synthetic tests and their identification")
    fit = identify(twin(truth))
    progress("voyages and grounding distances")
    voyages = [sailed(truth, y) for y in SHOWN_STARTS]
    readings = grounding_readings(truth)
    numbers: dict[str, Any] = {
        "coefficients": [_coefficient(fit, truth, name) for name in truth.terms.names],
        "shapley": [_share(fit, name) for name in truth.terms.names],
        "readings": [{"name": name, "switch": switch_of(d)} for name, d in readings.items()],
        "eigenvalues": {"with the bank": _modes(truth, True), "without": _modes(truth, False)},
        "stiffness": bank_stiffness(truth.configuration),
    }
    progress("figures")
    page = render(
        "paper.html.j2", title="The paper, reproduced", figures=_figures(fit, truth, voyages, readings),
        kinds=KINDS, printed_switch=PRINTED_SWITCH, doubts=_doubts(fit), source=truth.source.text,
        clusters=fit.clusters.sentence, verdict=_agreement(numbers["readings"]),
        voyages=list(zip(SHOWN_STARTS, [v.outcome.sentence for v in voyages], strict=True)),
        **numbers,
    )  # fmt: skip
    write_whole(path, page)
    return numbers


def sailed(model: Model, y: float) -> Voyage:
    """Sail as the paper does: 1 m/s, a constant surge force, the speed free (ours: the mass in surge).

    Parameters
    ----------
    model : Model
        The ship.
    y : float [m]
        Start.
    """
    return simulate(model, y, 1.0, 120.0, surge="free", surge_inertia=SURGE_MASS, X=SURGE_FORCE)


def grounding_readings(model: Model) -> dict[str, Any]:
    """Sail from every start under each reading of contact, with Coriolis and without (ours).

    Parameters
    ----------
    model : Model
        The ship.
    """
    heavy = replace(
        model, configuration=replace(model.configuration, ship=replace(model.configuration.ship, mass=MASS))
    )
    common: dict[str, Any] = {"y": STARTS, "duration": 120.0, "surge": "free", "X": SURGE_FORCE}
    common["surge_inertia"] = SURGE_MASS
    return {
        "hull corners": ensemble(model, **common),
        "midship clearance": ensemble(model, contact="midship", **common),
        "hull corners, with Coriolis": ensemble(heavy, coriolis=True, **common),
        "midship clearance, with Coriolis": ensemble(heavy, coriolis=True, contact="midship", **common),
    }


def switch_of(voyages: Any) -> float | None:
    """Return the smallest start [m] beyond which every ship grounds to starboard, None where there is none (ours).

    Parameters
    ----------
    voyages : Dataset
        Over ``y``, rising.
    """
    elsewhere = np.flatnonzero(voyages["side"].to_numpy() <= 0)
    first = int(elsewhere[-1]) + 1 if elsewhere.size else 0
    return float(voyages["y"][first]) if first < voyages.sizes["y"] else None


def _coefficient(fit: Fit, truth: Model, name: str) -> dict[str, Any]:
    std, verdict = fit.std[name], fit.verdicts[name]
    low, high = fit.intervals[name]
    printed = truth.coefficients[name]
    known = verdict.determined
    return {
        "name": name,
        "printed": f"{printed:g}",
        "found": readable(fit.coefficients[name], std) if known else "-",
        "interval": interval((low, high), std) if known else "-",
        "verdict": verdict.status,
        "kind": verdict.status.replace(" ", "-"),
        "why": _why(known, low <= printed <= high),
    }


def _why(known: bool, inside: bool) -> str:
    if not known:
        return "these tests cannot say; the paper's number is its solver's choice"
    return "" if inside else "outside the 95 % interval, as one in twenty is"


def _agreement(readings: list[dict[str, Any]]) -> str:
    """Say which readings switch where the paper does, to its one digit."""
    near = [r["name"] for r in readings if r["switch"] is not None and abs(r["switch"] - PRINTED_SWITCH) < 0.05]
    which = ", ".join(near) or "None of these readings"
    return f"{which} {'switches' if len(near) < 2 else 'switch'} where the paper does; the physics is left as it is."


def _share(fit: Fit, name: str) -> dict[str, Any]:
    force = next(force for force, own in fit.terms.forces.items() if name in [term.name for term in own])
    return {"name": name, "printed": PRINTED_SHARES[name], "ours": [fit.shapley(kind)[force][name] for kind in KINDS]}


def _modes(model: Model, bank: bool) -> list[str]:
    return [f"{z.real:+.3f}{z.imag:+.3f}i" for z in eigenvalues(model, bank=bank, u=1.0)]


def _doubts(fit: Fit) -> list[str]:
    return [verdict.sentence(name) for name, verdict in fit.verdicts.items() if verdict.status != "identified"]


def _figures(fit: Fit, truth: Model, voyages: list[Voyage], readings: dict[str, Any]) -> dict[str, dict[str, str]]:
    tests, configuration = fit.tests, truth.configuration
    distances = {name: grounding_distance(voyages) for name, voyages in readings.items()}
    sides = {name: voyages["side"] for name, voyages in readings.items()}
    return {
        "tests": figure(tests_figure(tests), "Synthetic tests A, B (harmonic yaw) and C (harmonic sway)."),  # type: ignore[arg-type]
        "delta": figure(delta_figure(configuration, fit.data_range.abs_y), "delta against y, and with the taper."),
        "surface": figure(delta_surface_figure(configuration), "delta over offset and heading."),
        "correlation": figure(correlation_figure(fit), "Correlations between the columns, and rank."),
        "forces": figure(forces_figure(fit, tests), "Forces measured and estimated, with the bank's part."),  # type: ignore[arg-type]
        "shapley": figure(shapley_figure(fit), "Shapley shares under three value functions."),
        "paths": figure(paths_figure(voyages, configuration), "Voyages from the starts of the table, hull corners."),
        "distance": figure(
            distances_figure(distances, sides, configuration), "Distance along the canal to the grounding."
        ),
    }
