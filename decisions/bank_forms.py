"""Every form of the bank term on the measured tests: tables and figure of docs/bank-forms.md (drawn by `make docs`).

python decisions/bank_forms.py          # prints them
python decisions/bank_forms.py --write  # and puts them into docs/
"""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from pages import markdown, publish

import narrows as nw
from narrows.model.tables import without_bank
from narrows.report.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE
from narrows.report.style import panels

NO_DRIFT, PROPELLER_ON, PROPELLER_OFF = "BCDFHIJ", "BDIJ", "CFH"
NO_BANK = "no bank"
COMPARED = ("delta", "distance", "tuck", NO_BANK)
HEAD = ("tests", "form", "force", "rmse_left_out", "coefficient", "value")
MARKERS = ("o", "^", "s", "D", "v", "P")
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, GREY, BLACK)
KCS = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}


def bank_only(form: str) -> nw.TermTable:
    """Return a table of a bank form alone, for steady tests along a bank without drift or yaw."""
    return nw.TermTable(f"bank only: {form}", (), nw.FORMS[form].sway, nw.FORMS[form].yaw)


def steady(names: str) -> nw.CaptiveTests:
    """Return some of the ten bank tests."""
    tests = nw.measured_tests("lataire2009")
    return tests.where([name in names for name in tests.names])


def sets() -> dict[str, nw.Comparison]:
    """Fit every form to every set of tests."""
    kcs = nw.measured_tests("kcs").by_condition()
    named = [*(nw.with_bank(nw.CROSSFLOW, form, form) for form in nw.FORMS), without_bank(nw.CROSSFLOW)]
    alone = [bank_only(form) for form in nw.FORMS]
    found = {f"KCS, {clearance}": nw.compare(kcs[label], named) for label, clearance in KCS.items()}
    for names, said in (
        (NO_DRIFT, "seven tests"),
        (PROPELLER_ON, "propeller on"),
        (PROPELLER_OFF, "propeller stopped"),
        (NO_DRIFT.replace("D", ""), "without D"),
    ):
        found[f"banks, {said}"] = nw.compare(steady(names), alone)
    return found


def cell(row: dict, name: str) -> str:  # type: ignore[type-arg]
    """Write a coefficient with its interval and verdict."""
    own = row["bank"][name]
    if not np.isfinite(own["ci95"]).all():
        return str(own["verdict"])
    low, high = own["ci95"]
    return f"{own['value']:.3f} ({low:.3f} to {high:.3f}), {own['verdict']}"


def without_any(comparison: nw.Comparison) -> list[float]:
    """Errors of Y and N on tests left out where no bank is modelled: hull terms alone, or nothing."""
    name = next((name for name in comparison.fits if name.endswith("open_water")), None)
    if name:
        return [comparison.fits[name].left_out[force].rmse for force in "YN"]
    columns = next(iter(comparison.fits.values())).tests.columns
    return [float(np.sqrt(np.mean(columns[force] ** 2))) for force in "YN"]


def full_rows(found: dict[str, nw.Comparison]) -> Iterator[tuple[str, ...]]:
    """Yield set, form, force, error on tests left out, coefficient, and its value with interval and verdict."""
    for label, comparison in found.items():
        rows = {(row["table"], row["force"]): row for row in comparison.rows()}
        for name in nw.FORMS:
            for force in "YN":
                row = rows[name if (name, force) in rows else f"bank only: {name}", force]
                for own in row["bank"]:
                    yield label, name, force, f"{row['rmse_left_out']:.3g}", own, cell(row, own)
        for force, error in zip("YN", without_any(comparison), strict=True):
            yield label, NO_BANK, force, f"{error:.3g}", "", ""


def tables(found: dict[str, nw.Comparison]) -> Iterator[str]:
    """Yield the errors of some forms, and the coefficients of one, and of two on the banks."""
    rows = list(full_rows(found))
    errors = {(label, name, force): error for label, name, force, error, _, _ in rows}
    yield "Errors of Y [N] and N [N m] on tests left out in turn:\n"
    yield markdown(
        ("tests", *COMPARED),
        [(label, *(f"{errors[label, name, 'Y']}, {errors[label, name, 'N']}" for name in COMPARED)) for label in found],
    )
    yield "\nCoefficients with 95 % intervals:\n"
    cells = {(label, name, force): own for label, name, force, _, _, own in rows}
    shown = [("delta", label) for label in found if "without" not in label] + [("distance", "banks, seven tests")]
    rows = [(label, name, cells[label, name, "Y"], cells[label, name, "N"]) for name, label in shown]
    yield markdown(("tests", "form", "b_bank", "c_bank"), rows)


def sign_change() -> Iterator[str]:
    """Yield what the seven tests say of the depth at which suction turns to repulsion, and which tests would tell."""
    fit, plain = (nw.identify(steady(NO_DRIFT), bank_only(form)) for form in ("distance_depth", "distance"))
    (low, high), near, far = fit.intervals["b_bank_depth"], fit.coefficients["b_bank_depth"], fit.coefficients["b_bank"]
    told = "excludes" if not low <= 0 <= high else "contains"
    errors = fit.left_out["Y"].rmse, plain.left_out["Y"].rmse
    yield (
        f"\nBy `distance_depth` suction turns to repulsion at h/T = {1 - near / far:.2f} in the seven tests. But the "
        f"interval of b_bank_depth (the coefficient of y_B T/(h - T)), {low:.3f} to {high:.3f}, {told} 0, and on "
        f"left-out tests the form errs by {errors[0]:.2f} N, `distance` by {errors[1]:.2f} N."
    )
    configuration = nw.Configuration(nw.Ship(4.01, 0.53, 0.18, 0.65), nw.Canal(6.33, 0.36))
    tank = nw.Tank(speeds=(0.458, 0.572), depths=(0.198, 0.216, 0.243, 0.36))
    terms = nw.with_bank(nw.PAPER, "distance_depth")
    plan = nw.plan_tests(configuration, 4, tank=tank, terms=terms, targets=("b_bank", "b_bank_depth"))
    runs = ", ".join(
        " and ".join(dict.fromkeys(word.format(row[name]) for row in plan.rows()))
        for name, word in (("offset", "y = {:.2f} m"), ("speed", "{:g} m/s"), ("depth", "depth {:.2f} m"))
    )
    yield (
        f"\n`nw.plan_tests` proposes four straight runs: {runs}. They would reduce the standard error of b_bank_depth "
        f"from {fit.std['b_bank_depth']:.3f} to {plan.std['b_bank_depth'][-1]:.4f}."
    )


def signs() -> Iterator[str]:
    """Yield the sign of the yaw moment on the clean cases, each predicted from the other tests."""
    rows = []
    for name in "DFH":
        predicted = []
        for form in nw.FORMS:
            table = bank_only(form)
            model = nw.identify(steady(NO_DRIFT.replace(name, "")), table).model
            row = steady(name)
            values = {**row.configuration.values(), **{key: float(column[0]) for key, column in row.columns.items()}}
            predicted.append(sum(model.coefficients[term.name] * term.column(values) for term in table.yaw))
        ends = f"{min(predicted):.2f} to {max(predicted):.2f}"
        rows.append((name, f"{steady(name).columns['N'][0]:.2f}", ends))
    yield "\n" + markdown(("test", "measured N [N m]", "by the forms"), rows)


def shown_sets() -> dict[str, nw.Comparison]:
    """Return the sets of the page: those by propeller are in the figure."""
    return {label: one for label, one in sets().items() if "propeller" not in label}


def text() -> str:
    """Write everything that is computed."""
    return "\n".join([*tables(shown_sets()), *sign_change(), *signs()])


def figure() -> Figure:
    """Draw the error of each form of the bank term on left-out tests relative to the best, for sets of tests."""
    sets_shown = {
        label: {n.removeprefix("bank only: "): fit for n, fit in own.fits.items() if not n.endswith("open_water")}
        for label, own in sets().items() if "without D" not in label
    }  # fmt: skip
    names = list(next(iter(sets_shown.values())))
    figure, axes = panels(2, 1, 5.6, grid="y", sharex=True)
    for panel, force in zip(axes[:, 0], ("Y", "N"), strict=True):
        for i, (label, fits) in enumerate(sets_shown.items()):
            errors = np.array([fit.left_out[force].rmse for fit in fits.values()])
            style = {"marker": MARKERS[i % 6], "color": COLOURS[i % 6], "linestyle": "none", "markersize": 5}
            panel.plot(np.arange(len(names)) + 0.09 * (i - 2.5), errors / errors.min(), label=label, **style)
        panel.set(yscale="log", ylabel=f"RMSE of left-out {force},\nover the best form's [1]")
        panel.yaxis.set_major_formatter("{x:g}")
    axes[1, 0].set_xticks(range(len(names)), names, rotation=20, ha="right")
    axes[1, 0].set_xlabel("form of the bank term [-]")
    axes[0, 0].legend(frameon=False, fontsize=6.5, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=1)
    return figure


if __name__ == "__main__":
    publish(__file__, "bank-forms.md", text())
    if "--write" in sys.argv:
        with Path(__file__).with_suffix(".csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([HEAD, *full_rows(shown_sets())])
