"""What a model from main dimensions is worth: formulas on known ships, ships left out, KVLCC2's trials, the banks.

python decisions/main_dimensions.py [--write]

KVLCC2 is estimated by the other ships. Its measured circles and zigzags are those of ``decisions/manoeuvres.py``.
"""

import math
import re
from dataclasses import replace
from functools import cache

import numpy as np
from bank_evidence import BANK_EVIDENCE, BankEvidence, bank_effects, left_out, left_out_banks
from known_ships import KNOWN_SHIPS, calibrated
from manoeuvres import APPROACH, CIRCLES, OVERSHOOTS
from pages import Rows, markdown, part, publish, records

import narrows as nw
from narrows.empirical.formulas import BANK_PRIOR, FORMULAS, SIGNED, depth_factor
from narrows.quantities.names import KNOT
from narrows.simulation.grid import sampled

DRAWN = 60
"""Ships drawn from the covariance, each sailed through its trials."""


LINEAR = tuple(name for name in SIGNED if name in ("X_my", "N_jz", "Y_v", "Y_r", "N_v", "N_r"))


def formula_table() -> str:
    """Ratios of all formulas to the known values, by coefficient."""
    rows = []
    for name in LINEAR:
        laws = [formula.law for formula in FORMULAS if formula.coefficient == name]
        known = [(ship.hull, ship.primes.get(math.inf, {}).get(name)) for ship in KNOWN_SHIPS]
        ratios = np.array([[law(hull) / value for hull, value in known if value] for law in laws])
        rows.append((name, str(len(laws)), str(ratios.shape[1]), f"{ratios.min():.2f} to {ratios.max():.2f}"))
    return markdown(("coefficient", "formulas", "ships", "formula over known value"), rows)


def clarke_table() -> str:
    """Values of KVLCC2 and the KCS beside Clarke's formulas alone, and beside the estimate by the other ships."""
    laws = {one.coefficient: one.law for one in FORMULAS if one.source.startswith("Clarke")}
    rows = []
    for ship in (ship for ship in KNOWN_SHIPS if ship.name in ("KVLCC2", "KCS")):
        others, ratio = calibrated(tuple(other for other in KNOWN_SHIPS if other is not ship)), max(ship.primes)
        for name in LINEAR:
            value = ship.primes[ratio][name] / depth_factor(name, ship.hull, ratio)
            alone, own = float(laws[name](ship.hull)), others.estimate(name, ship.hull)
            off = [f"{100 * (one / value - 1):+.0f} %" for one in (alone, own.value)]
            low, high = (own.value + sign * 1.96 * own.std for sign in (-1, 1))
            rows.append((ship.name, name, f"{value:.3f}", f"{alone:.3f} ({off[0]})", f"{own.value:.3f} ({off[1]})",
                         f"{low:.3f} to {high:.3f}"))  # fmt: skip
    heads = ("ship", "coefficient", "known", "Clarke (1983) alone", "estimate by the other ships", "95 % interval")
    return markdown(heads, rows)


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
    others = calibrated(tuple(ship for ship in KNOWN_SHIPS if ship.name != "KVLCC2"))
    ship = {"length": 7.0, "beam": 1.27, "draft": 0.46, "block_coefficient": 0.81}
    gear = nw.SteeringGear(35.0, 15.8)
    setting = nw.Canal(700.0), nw.Water(1000.0)
    return nw.estimate_model(ship, *setting, kind="tanker", speed=APPROACH, steering=gear, calibration=others)


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
        held = " and ".join("yes" if low <= side <= high else "no" for side in sides)
        pair = f"{sides[0]:.1f}, {sides[1]:.1f}"
        rows.append((name, f"{middle:.1f}", f"{low:.1f} to {high:.1f}", pair, held, f"{off:+.0f} %"))
    heads = (
        "measure", "median", "90 % interval", "measured, starboard and port", "in the interval",
        "median over the mean of both",
    )  # fmt: skip
    if sailed:
        rows.append(("ships whose trials failed", "", f"{failed} of {DRAWN}", "", "", ""))
    return markdown(heads, rows)


def bank_table() -> str:
    """The evidence on the bank's coefficients by ship and kind of test, and their distribution."""
    groups: dict[tuple[str, str], list[BankEvidence]] = {}
    for row in BANK_EVIDENCE:
        groups.setdefault((row.ship, "harmonic" if row.suction_error else "steady"), []).append(row)
    rows = [
        (ship, tests, str(len(group)), _spans([(row.suction, row.suction_error) for row in group]),
         _spans([(row.cushion, row.cushion_error) for row in group]))
        for (ship, tests), group in groups.items()
    ]  # fmt: skip
    effects, prior = bank_effects(), BANK_PRIOR
    pair = (effects["Y_bank"], effects["N_bank"])
    rows += [
        ("all", "mean", "", *(f"{one.mean:.2f} ± {one.mean_error:.2f}" for one in pair)),
        ("", "standard deviation between ships", "", *(f"{one.between:.2f}" for one in pair)),
        ("", "standard deviation within a ship", "", *(f"{one.within:.2f}" for one in pair)),
        ("a further ship", "", "", *(f"{prior[name].value:.2f} ± {prior[name].std:.2f}" for name in prior)),
    ]
    return markdown(("ship", "tests", "number", "b_bank", "c_bank"), rows)


def _spans(pairs: list[tuple[float | None, float]]) -> str:
    """Write the range of values and that of their standard errors."""
    known = [(value, error) for value, error in pairs if value is not None]
    if not known:
        return ""
    values, errors = zip(*known, strict=True)
    return f"{_span(values)} ± {_span(errors)}" if any(errors) else _span(values)


def _span(numbers: tuple[float, ...]) -> str:
    return " to ".join(dict.fromkeys(f"{end:.2f}" for end in (min(numbers), max(numbers))))


def left_out_banks_table() -> str:
    """How many coefficients of the bank the 95 % intervals by the other ships hold."""
    found = left_out_banks()
    rows = []
    for ship in dict.fromkeys(row.ship for row in found):
        group = [row for row in found if row.ship == ship]
        missed = ", ".join(f"{row.coefficient} {row.known:.2f}" for row in group if not row.held)
        rows.append((ship, str(len(group)), str(sum(row.held for row in group)), missed))
    rows.append(("all", str(len(found)), str(sum(row.held for row in found)), ""))
    return markdown(("ship", "coefficients", "in their 95 % interval", "outside"), rows)


PLACES = {
    "KCS, 300 x 16.2 m": (nw.published("estimated_kcs"), 8.0),
    "366 m, 300 x 24 m": (nw.estimate_model(nw.Ship(366, 51, 15, 0.65), nw.Canal(300, 24)), 8.0),
    "400 m, 205 x 24 m (Suez)": (nw.estimate_model(nw.Ship(400, 58.8, 16, 0.68), nw.Canal(205, 24)), 7.0),
}
"""Ships in canals, and a speed [knots]."""

KNOWN_PARTS = {
    "as estimated": (),
    "hull known": ("X_my", "Y_my", "N_jz", "Y_v", "Y_r", "N_v", "N_r"),
    "rudder known": ("X_rudder", "Y_rudder", "N_rudder"),
    "bank known": ("Y_bank", "N_bank"),
}
"""Coefficients without uncertainty."""

CASES = 400


def narrowing_table(sailed: bool) -> str:
    """Shares of controllable cases, each with one source of spread switched off; heads alone where none is sailed."""
    columns = (*KNOWN_PARTS, "heading 1 deg off, not 2")
    rows = []
    for name, (model, knots) in PLACES.items() if sailed else ():
        beam = model.configuration.ship.beam
        models = [replace(model, covariance=_without(model, parts)) for parts in KNOWN_PARTS.values()]
        asked = [(one, None) for one in models] + [(model, nw.Disturbance(heading_deg=1.0))]
        places, shares = np.array([0.0, beam / 2, beam]), []
        for one, disturbance in asked:
            found = nw.safe_envelope(one, places, np.array([knots * KNOT]), disturbance=disturbance, samples=CASES)
            shares.append(found.to_xarray()["held"].values[:, 0])
        rows += [
            (name, f"{place:.0f}", *(f"{100 * share[index]:.0f} %" for share in shares))
            for index, place in enumerate(places)
        ]
    return markdown(("ship and canal", "offset [m]", *columns), rows)


def _without(model: nw.Model, parts: tuple[str, ...]) -> np.ndarray:
    """Covariance without some coefficients."""
    kept = np.array([name not in parts for name in model.terms.names], float)
    return np.asarray(model.covariance * np.outer(kept, kept))


def text(sailed: bool = True) -> str:
    """All tables, each below its words; without the trials, which take two minutes, where none is sailed."""
    return "\n\n".join((
        "Formulas over the known values of ships in deep water:", formula_table(),
        "Linear coefficients in deep water (the KCS's by the laws of depth). `clarke83` of the MSS toolbox has "
        "Clarke's formulas alone, without a spread:", clarke_table(),
        "Each ship estimated by the others:", left_out_table(),
        "KVLCC2's 7 m model, from length, beam, draft and block coefficient, by the other ships:", trials_table(sailed),
        "Evidence on the bank's coefficients, in the form `distance` (Y_bank and N_bank in estimated models):",
        bank_table(),
        "The bank's coefficients of each ship by the other ships:", left_out_banks_table(),
        "Cases that stay controllable at 8 knots (in Suez 7), each with one source of spread switched off:",
        narrowing_table(sailed),
    ))  # fmt: skip


def shown(rows: Rows) -> str:
    """Trials, evidence and sources of spread; of the other tables what they come to."""
    linear = records(rows, "ship", "coefficient")
    alone, estimate = ([abs(float(re.search(r"([+-]\d+) %", row[name]).group(1))) for row in linear]
                       for name in ("Clarke (1983) alone", "estimate by the other ships"))  # fmt: skip
    hulls, banks = records(rows, "water"), records(rows, "ship", "coefficients")
    ends = [float(end) for row in records(rows, "coefficient") for end in row["formula over known value"].split(" to ")]
    places = [row for row in records(rows, "ship and canal") if int(row["as estimated"].split()[0]) > 50]
    return "\n\n".join((
        f"Single formulas give {min(ends):.2f} to {max(ends):.2f} times the known values of ships in deep water.",
        f"Errors of {len(linear)} linear coefficients of KVLCC2 and the KCS: median {np.median(alone):.0f} %, largest "
        f"{max(alone):.0f} % by Clarke (1983) alone, as `clarke83` of the MSS toolbox. The estimate from the other "
        f"ships has {np.median(estimate):.0f} and {max(estimate):.0f} %.",
        f"Each ship estimated by the others: the 95 % intervals hold {hulls[-1]['in their 95 % interval']} of "
        f"{hulls[-1]['coefficients']} coefficients of the hull, all but {hulls[-1]['outside']}; and "
        f"{banks[-1]['in their 95 % interval']} of {banks[-1]['coefficients']} of the bank.",
        "KVLCC2's 7 m model, from length, beam, draft and block coefficient, by the other ships:",
        part(records(rows, "measure"), "measure", "median", "90 % interval", "measured, starboard and port"),
        "Evidence on the bank's coefficients, in the form `distance` (Y_bank and N_bank in estimated models):",
        part(records(rows, "ship", "tests")),
        "Cases that stay controllable at 8 knots (in Suez 7), each with one source of spread switched off:",
        part(places, *(name for name in places[0] if not name.startswith(("rudder", "heading")))),
    ))  # fmt: skip


if __name__ == "__main__":
    publish(__file__, "main-dimensions.md", text(), shown)
