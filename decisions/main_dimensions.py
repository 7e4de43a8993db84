"""What a model from main dimensions is worth: formulas on known ships, ships left out, KVLCC2's trials, the banks.

python decisions/main_dimensions.py [--write]

KVLCC2 is estimated by the other ships. Its measured circles and zigzags are those of ``decisions/manoeuvres.py``.
"""

import math
from functools import cache

import numpy as np
from manoeuvres import APPROACH, CIRCLES, OVERSHOOTS
from pages import markdown, publish

import narrows as nw
from narrows.empirical.calibration import SIGNED, Calibration, left_out
from narrows.empirical.formulas import FORMULAS
from narrows.empirical.known_ships import KNOWN_SHIPS
from narrows.empirical.main_dimensions import BANK_EVIDENCE, bank_prior, estimated
from narrows.simulation.grid import sampled

DRAWN = 60
"""Ships drawn from the covariance, each sailed through its trials."""


def formula_table() -> str:
    """Each formula of the signed linear derivatives over the known value, ship by ship."""
    shown = [name for name in SIGNED if name in ("X_my", "N_jz", "Y_v", "Y_r", "N_v", "N_r")]
    ships = [ship for ship in KNOWN_SHIPS if math.inf in ship.primes]
    rows = []
    for formula in FORMULAS:
        if formula.coefficient in shown:
            known = [ship.primes[math.inf].get(formula.coefficient) for ship in ships]
            ratios = [
                formula.law(ship.hull) / value if value else None for ship, value in zip(ships, known, strict=True)
            ]
            cells = ["" if ratio is None else f"{ratio:.2f}" for ratio in ratios]
            rows.append((formula.coefficient, formula.source, *cells))
    return markdown(("coefficient", "formula over known", *(ship.name for ship in ships)), rows)


def left_out_table() -> str:
    """How many known values of left-out ships the 95 % intervals hold, by depth."""
    found = left_out()
    depths = sorted({row.depth_to_draft for row in found}, reverse=True)
    groups = [("deep" if math.isinf(depth) else f"h/T {depth:g}", [row for row in found if row.depth_to_draft == depth])
              for depth in depths]  # fmt: skip
    rows = [
        (name, str(len(group)), str(sum(row.held for row in group)), ", ".join(_missed(group)))
        for name, group in [*groups, ("all", found)]
    ]
    return markdown(("water", "coefficients", "in their 95 % interval", "outside"), rows)


def _missed(group: list) -> list[str]:
    return sorted({f"{row.coefficient} of {row.ship}" for row in group if not row.held})


@cache
def kvlcc2() -> nw.Model:
    """KVLCC2's 7 m model from its dimensions, by the other ships."""
    others = Calibration(tuple(ship for ship in KNOWN_SHIPS if ship.name != "KVLCC2"))
    ship = {"length": 7.0, "beam": 1.27, "draft": 0.46, "block_coefficient": 0.81}
    gear = nw.SteeringGear(35.0, 15.8)
    return estimated(ship, nw.Canal(700.0), nw.Water(1000.0), "tanker", APPROACH, None, None, gear, others)


@cache
def drawn_trials(count: int = DRAWN) -> tuple[dict[str, np.ndarray], int]:
    """Advance and tactical diameter over L and first overshoots [deg] of drawn ships; how many did not finish."""
    model = kvlcc2().in_open_water()
    columns = sampled(model, count, 0)
    rows, failed = [], 0
    for index in range(count):
        one = model.with_coefficients({name: float(column[index]) for name, column in columns.items()})
        try:
            found = nw.sail_trials(one, APPROACH).to_dict()
        except nw.InputError:
            failed += 1
            continue
        circle, zigzags = found["turning"]["+35"], found["zigzags"]
        overshoots = [zigzags[name]["overshoots_deg"][0] for name in ("+10/10", "+20/20")]
        rows.append((circle["advance_over_length"], circle["tactical_diameter_over_length"], *overshoots))
    names = ("advance/L", "tactical diameter/L", "first overshoot 10/10 [deg]", "first overshoot 20/20 [deg]")
    return dict(zip(names, np.array(rows).T, strict=True)), failed


def measured() -> dict[str, tuple[float, float]]:
    """To starboard and to port."""
    plus, minus = CIRCLES["+35"], CIRCLES["-35"]
    return {
        "advance/L": (plus[0], minus[0]),
        "tactical diameter/L": (plus[2], minus[2]),
        "first overshoot 10/10 [deg]": (OVERSHOOTS["+10/10"][0], OVERSHOOTS["-10/10"][0]),
        "first overshoot 20/20 [deg]": (OVERSHOOTS["+20/20"][0], OVERSHOOTS["-20/20"][0]),
    }


def trials_table(sailed: bool) -> str:
    """KVLCC2's trials from dimensions alone, against the free-running tests; the heads alone where none is sailed."""
    rows = []
    drawn, failed = drawn_trials() if sailed else ({}, 0)
    for name, sides in measured().items() if sailed else ():
        low, middle, high = np.percentile(drawn[name], [5, 50, 95])
        off = 100 * (middle / np.mean(sides) - 1)
        rows.append(
            (name, f"{middle:.1f}", f"{low:.1f} to {high:.1f}", f"{sides[0]:.1f}, {sides[1]:.1f}", f"{off:+.0f} %")
        )
    heads = ("measure", "median", "90 % interval", "measured, starboard and port", "median over the mean of both")
    if sailed:
        rows.append(("ships that finished no trial", "", f"{failed} of {DRAWN}", "", ""))
    return markdown(heads, rows)


def bank_table() -> str:
    """The evidence on the bank's coefficients, and their distribution."""
    rows = [
        (row.ship, row.source, "not known" if row.depth_to_draft is None else f"{row.depth_to_draft:g}",
         f"{row.suction:.3f}", f"{row.cushion:.3f}")
        for row in BANK_EVIDENCE
    ]  # fmt: skip
    prior = bank_prior()
    pair = (prior["Y_bank"], prior["N_bank"])
    rows.append(
        ("a further ship", "mean and standard deviation", "any", *(f"{one.value:.2f} ± {one.std:.2f}" for one in pair))
    )
    return markdown(("ship", "source", "h/T", "b_bank", "c_bank"), rows)


def text(sailed: bool = True) -> str:
    """All tables, each below its words; without the trials, which take half a minute, where none is sailed."""
    return "\n\n".join((
        "A formula over the known value, ship by ship, in deep water:", formula_table(),
        "Each ship estimated by the others:", left_out_table(),
        "KVLCC2's 7 m model, from length, beam, draft and block coefficient, by the other ships:", trials_table(sailed),
        "What is known of the bank's coefficients, in the paper's form:", bank_table(),
    ))  # fmt: skip


if __name__ == "__main__":
    publish(__file__, "main-dimensions.md", text())
