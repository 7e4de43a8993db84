"""Squat formulas on measured sinkage: the table of docs/squat.md.

python decisions/squat.py [--write]
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd
from pages import markdown, publish

import narrows as nw
from narrows.captive.layouts import BANKS, WALL
from narrows.captive.measured import measured_files
from narrows.model.water import limits_left
from narrows.quantities.names import evaluate

SQUAT_RUNS = measured_files("kcs")[0].with_name("lataire2009_squat.csv")

Run = tuple[nw.Configuration, float, dict[str, float]]
DEPTHS = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
STRAIGHT = "type == 'STATX0' and abs(v_mps) < 1e-6 and abs(psi_deg) < 1e-6 and u_mps > 0.1 and abs(rud_given_deg) < 1"


def lataire() -> Iterator[Run]:
    """Fifteen runs along bank V, taken as the wall that leaves the same section; sinkage at bow and stern, measured."""
    ship = replace(nw.read_ship(measured_files("lataire2009")[1]).ship, draft=0.18)
    width = nw.equivalent_wall(BANKS["V"], 0.243) + WALL
    for _, row in pd.read_csv(SQUAT_RUNS).iterrows():
        fore, aft = row["sinkage fore [mm]"] / 1e3, row["sinkage aft [mm]"] / 1e3
        middle = (fore + aft) / 2
        measured = {"bow": fore, "midship": middle, "mean": middle, "largest": max(fore, aft)}
        yield nw.Configuration(ship, nw.Canal(width, 0.243)), float(row["u [m/s]"]), measured


def kcs(label: str) -> Iterator[Run]:
    """The steady straight runs of the KCS at one depth; midship sinkage alone."""
    table, ship = measured_files("kcs")
    configuration = nw.read_ship(ship)
    rows = pd.read_csv(table).query(f"env == '{label}' and {STRAIGHT}")
    for _, row in rows.iterrows():
        canal = nw.Canal(configuration.canal.width, configuration.depths[label])
        yield (
            nw.Configuration(configuration.ship, canal),
            float(row["u_mps"]),
            dict.fromkeys(("midship", "mean"), row["sinkage_mm"] / 1e3),
        )


def cell(formula: nw.SquatFormula, runs: list[Run]) -> str:
    """Root mean square and median error of a formula, and where not all runs are within its limits how many are."""
    seen = [(s, u, m[formula.gives]) for s, u, m in runs if formula.gives in m and u < nw.choke_speed(s)]
    if not seen:
        return ""
    told = np.array([float(evaluate(formula.function, {**s.values(), "u": u})) for s, u, _ in seen])
    measured = np.array([m for _, _, m in seen])
    inside = sum(not limits_left(formula, s, u) for s, u, _ in seen)
    bias, spread = 100 * np.median(told / measured - 1), 1e3 * np.sqrt(np.mean((told - measured) ** 2))
    noted = "" if inside == len(seen) else f", {inside} of {len(seen)} within its limits"
    return f"{bias:+.0f} %, {spread:.2f} mm{noted}"


def text() -> str:
    """Hold every formula to every set of runs."""
    sets = {"8000 TEU, 35 %, sloping bank": list(lataire())}
    sets |= {f"KCS, {said}": list(kcs(label)) for label, said in DEPTHS.items()}
    means = (f"{label}, {1e3 * np.mean([m['midship'] for _, _, m in runs]):.1f} mm" for label, runs in sets.items())
    rows = [(f"`{name}`, {own.gives}", *(cell(own, runs) for runs in sets.values())) for name, own in nw.SQUAT.items()]
    return markdown(("formula", *means), rows)


if __name__ == "__main__":
    publish(__file__, "squat.md", text())
