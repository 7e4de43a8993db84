"""One page for the crew of a leg: where, how fast, what to expect, what to write, when to break off."""

import textwrap
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from narrows.files import form_of, save_figure, write_whole
from narrows.logbook import InformationForecast, SteadyPlan
from narrows.logbook.learned_coefficient import ON_TWINS, PRIOR, LearnedCoefficient
from narrows.quantities.names import KNOT
from narrows.report.fit_page import figure as captioned
from narrows.report.fit_page import render
from narrows.report.style import BLACK, BLUE, DASHES, FONT, GREEN, GREY, ORANGE, PURPLE, Margins, Picture, panels
from narrows.report.terminal import print_result, table_of
from narrows.results.base_results import interval, with_error

# A4, portrait [in].
PAGE = (8.27, 11.69)
FORMS = (".html", ".pdf", ".svg", ".png")

HEADS = (
    "leg", "offset from\nthe middle", "through\nthe water", "rudder\nto expect", "bow off course\nto expect",
    "offset [m]", "speed [kn]", "rudder [deg]\n+ starboard", "heading less\ncourse [deg]",
)  # fmt: skip

FIRST_BLANK, WIDTHS = 5, (0.055, 0.135, 0.085, 0.15, 0.155, 0.095, 0.095, 0.11, 0.12)
# Yaw rate [deg/s] below which a leg is steady, and distance off its line [beams] at which it is broken off.
MOST_TURNING, STRAYED = 0.02, 0.25
# Characters in a line of the steps, plain and bold.
WRAPPED, BOLD = 104, 88


def pilot_page(plan: SteadyPlan) -> Figure:
    with rc_context(FONT):
        page = Picture(figsize=PAGE)
        _heading(page, plan)
        _draw_canal(page.add_axes((0.1, 0.695, 0.8, 0.195)), plan)
        _draw_steps(page.add_axes((0.08, 0.355, 0.86, 0.285)), plan)
        _draw_table(page.add_axes((0.05, 0.1, 0.9, 0.225)), plan)
        _foot(page, plan)
    return page


def write_pilot_page(plan: SteadyPlan, path: str | Path) -> None:
    if form_of(path, FORMS) != ".html":
        save_figure(pilot_page(plan), path)
        return
    caption = "; ".join([plan.summary().partition("\n")[0], *steps(plan)])
    title = f"Legs to hold: {plan.model.configuration.ship.name or 'the ship'}"
    write_whole(path, render("pilot.html.j2", title=title, page=captioned(pilot_page(plan), caption)))


def steps(plan: SteadyPlan) -> list[str]:
    ship, minutes = plan.model.configuration.ship, np.ceil(plan.settling / 60)
    run = max(leg.speed for leg in plan.legs) * (plan.settling + plan.conditions.leg_time)
    return [
        f"Choose a straight reach with no traffic and an even bank, some {run / 1852:.1f} nautical miles for each leg. "
        "The order of the legs cancels a wind that grows; break the row where the wind changes at once.",
        "Agree with the master, the engine and the traffic service. Leave the engine alone during a leg.",
        "Bring the ship to the leg's offset and hold it there, parallel to the canal, by hand or by autopilot. Give "
        f"it {minutes:.0f} minutes. It is steady when the offset changes by less than {2 * plan.errors.y:.2g} m in a "
        f"minute, the ship turns less than {MOST_TURNING:g} degrees per second, and the mean rudder no longer changes.",
        f"Then read for {plan.conditions.leg_time / 60:.2g} minutes, every 10 seconds, and write down the means: "
        "offset, speed through the water, rudder (indicator, not order), and heading less course over ground.",
        f"BREAK OFF and come back to the middle at once: if more than {np.degrees(plan.most_rudder):.0f} degrees of "
        f"rudder are needed to hold it, if it strays more than {STRAYED * ship.beam:.2g} m from its line, if the bow "
        "turns away from a bank and does not stop, for any traffic, and whenever the pilot or the master wishes.",
        "Repeat the first leg at the end if there is time: it shows whether anything changed meanwhile.",
    ]


def _heading(page: Figure, plan: SteadyPlan) -> None:
    configuration = plan.model.configuration
    page.text(
        0.5, 0.965, "Holding the ship to either side: what the bank does", ha="center", fontsize=15, weight="bold"
    )
    page.text(0.5, 0.945, configuration.summary(), ha="center", fontsize=9)
    blanks = "   ".join(f"{what} {14 * '_'}" for what in ("Date", "Reach", "Drafts", "Wind", "Pilot"))
    page.text(0.5, 0.918, blanks, ha="center", fontsize=8.5)


def _draw_canal(axes: Axes, plan: SteadyPlan) -> None:
    """The canal from above, with ahead up: each leg's hull at its offset."""
    ship, half = plan.model.configuration.ship, plan.model.configuration.canal.width / 2
    for sign in (-1, 1):
        axes.axvline(sign * half, color=BLACK, lw=4)
    axes.axvline(0, color=GREY, lw=0.8, ls="-.")
    places = sorted({leg.offset for leg in plan.legs})
    rows = dict(zip(places, _rows(places, ship.beam), strict=True))
    for offset in places:
        _draw_hull(axes, offset, rows[offset], ship.beam, BLUE if offset > 0 else ORANGE)
        numbers = ", ".join(str(i) for i, leg in enumerate(plan.legs, start=1) if leg.offset == offset)
        axes.text(
            offset, rows[offset] + 0.5, numbers, ha="center", va="center", fontsize=8, color="white", weight="bold"
        )
    axes.set(xlim=(-1.05 * half, 1.05 * half), ylim=(-0.1, max(rows.values()) + 1.25), yticks=[])
    axes.set_xticks([-half, *places, 0, half], [f"{x:+.3g}" if x else "0" for x in (-half, *places, 0, half)])
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(
        "metres from the middle, seen from above with the ship going up the page: port left, starboard right"
    )
    for sign, side in ((-1, "port bank"), (1, "starboard bank")):
        axes.text(
            sign * 0.97 * half, 0.06, side, rotation=90, va="bottom", ha="right" if sign > 0 else "left", fontsize=8
        )


def _rows(places: list[float], beam: float) -> list[float]:
    """Row in which each hull is drawn, so that neighbours do not overlap."""
    rows: list[float] = []
    for i, place in enumerate(places):
        taken = {row for other, row in zip(places[:i], rows, strict=True) if abs(other - place) < 1.1 * beam}
        rows.append(next(float(row) for row in range(len(places)) if row not in taken))
    return rows


def _draw_hull(axes: Axes, offset: float, row: float, beam: float, colour: str) -> None:
    side = beam / 2
    outline = ((-side, 0.0), (side, 0.0), (side, 0.75), (0.0, 1.0), (-side, 0.75))
    points = [(offset + across, row + 0.05 + 0.9 * along) for across, along in outline]
    axes.add_patch(Polygon(points, closed=True, facecolor=colour, edgecolor=BLACK, lw=0.8, alpha=0.85))


def _draw_steps(axes: Axes, plan: SteadyPlan) -> None:
    axes.axis("off")
    line, top = 0.062, 1.0
    for number, step in enumerate(steps(plan), start=1):
        urgent = step.startswith("BREAK")
        words = textwrap.wrap(step, BOLD if urgent else WRAPPED)
        if urgent:
            box = Rectangle((-0.012, top - line * (len(words) - 0.2)), 1.024, line * (len(words) + 0.35), fill=False,
                            edgecolor=ORANGE, lw=1.6, transform=axes.transAxes, clip_on=False)  # fmt: skip
            axes.add_patch(box)
        for part, text in enumerate(words):
            label = f"{number}." if part == 0 else ""
            axes.text(0.0, top, label, fontsize=9, weight="bold", transform=axes.transAxes, va="center")
            axes.text(
                0.03,
                top,
                text,
                fontsize=9,
                weight="bold" if urgent else "normal",
                transform=axes.transAxes,
                va="center",
            )
            top -= line
        top -= 0.35 * line


def _draw_table(axes: Axes, plan: SteadyPlan) -> None:
    axes.axis("off")
    cells = [
        [str(number), f"{abs(leg.offset):g} m {leg.side}", f"{leg.speed / KNOT:g} kn", _turned(leg.rudder),
         _turned(leg.drift, 1), "", "", "", ""]
        for number, leg in enumerate(plan.legs, start=1)
    ]  # fmt: skip
    cells.append([*("again", "as leg 1", "", "", ""), "", "", "", ""])
    table = axes.table(cells, colLabels=HEADS, colWidths=WIDTHS, loc="upper center", cellLoc="center")
    table.auto_set_font_size(False)
    table.set_fontsize(7.8)
    for (row, column), cell in table.get_celld().items():
        cell.set_linewidth(0.5)
        cell.set_height(0.16 if row == 0 else 0.84 / len(cells))
        if column >= FIRST_BLANK:
            cell.set_facecolor("#FFF7E6" if row == 0 else "white")
    axes.text(0.0, 1.03, "To hold and to expect", fontsize=9, weight="bold", transform=axes.transAxes)
    axes.text(sum(WIDTHS[:FIRST_BLANK]), 1.03, "To write: means", fontsize=9, weight="bold", transform=axes.transAxes)


def _turned(angles: tuple[float, ...], digits: int = 0) -> str:
    """A range of angles by side: P to port, S to starboard."""
    low, _, high = np.degrees(angles)
    return " to ".join(f"{'P' if angle < 0 else 'S'} {abs(angle):.{digits}f}°" for angle in (low, high))


def _foot(page: Figure, plan: SteadyPlan) -> None:
    lines = [
        "Rudder and bow to expect (P to port, S to starboard): 90 % intervals from the tests. "
        f"{plan.summary().splitlines()[0]}",
        "Afterwards: the means as held.csv with the columns leg, y [m], u [kn], rudder [deg], drift [deg] (starboard "
        "positive, port negative), then narrows learn MODEL --steady held.csv -o NEW.toml.",
        ON_TWINS,
    ]
    wrapped = [part for text in lines for part in textwrap.wrap(text, 138)]
    page.text(0.06, 0.02, "\n".join(wrapped), fontsize=7.2, va="bottom", color=GREY)


COLOURS = (BLACK, BLUE, ORANGE, GREEN, PURPLE)


def print_information(information: InformationForecast) -> None:
    columns = [f"std {name}" for name in information.targets]
    rows = (
        (str(row["transits"]), row["excursion"], *(f"{row[name]:.2g}" for name in columns))
        for row in information.rows()
    )
    print_result(information, table_of(("transits", "", *columns), rows) if information.kinds else None)


def information_figure(information: InformationForecast) -> Figure:
    targets = information.targets
    figure, axes = panels(1, len(targets), 3.6, Margins(bottom=1.35, top=0.25, across=0.75))
    for panel, name in zip(axes[0], targets, strict=True):
        panel.axhline(information.prior_std[name], color=GREY, ls="--", label="now")
        for number, kind in enumerate(information.kinds):
            style = DASHES[number % len(DASHES)]
            panel.plot(information.transits, kind.std[name], color=COLOURS[number % len(COLOURS)], ls=style, marker="o",
                       ms=3, label=kind.excursion.words)  # fmt: skip
        panel.set(xscale="log", xlabel="transits", ylabel=f"standard error of {name}")
        panel.set_xticks(information.transits, [str(count) for count in information.transits])
        panel.minorticks_off()
        panel.set_ylim(bottom=0)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=1 + (len(labels) > 3), frameon=False, fontsize=7)
    return figure


# Heads of a table of coefficients before and after a record.
LEARNED_HEADS = ("", "before", "after", "95 % interval", "unit")


def learned_rows(coefficients: Mapping[str, LearnedCoefficient]) -> list[tuple[str, ...]]:
    learned = sorted((c for c in coefficients.values() if c.word != PRIOR), key=lambda c: c.left)
    return [
        (c.name, with_error(c.prior, c.prior_std), with_error(c.value, c.std),
         interval(c.interval, c.std), c.unit, c.verdict)
        for c in learned
    ]  # fmt: skip


def with_truth(rows: list[tuple[str, ...]], truth: Mapping[str, float] | None) -> list[tuple[str, ...]]:
    return rows if truth is None else [(*row, f"{truth[row[0]]:.3g}") for row in rows]
