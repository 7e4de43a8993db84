"""What transits will tell, in the terminal and as a picture."""

from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from narrows.logbook import Foresight
from narrows.report.style import BLACK, BLUE, DASHES, GREEN, GREY, ORANGE, PURPLE, Margins, panels

COLOURS = (BLACK, BLUE, ORANGE, GREEN, PURPLE)


def print_foresight(foresight: Foresight) -> None:
    """Print how tight coefficients will get."""
    console = Console(highlight=False, markup=False)
    console.width = max(console.width, 110)
    console.print(foresight.summary())
    if foresight.kinds:
        table = Table(box=None, pad_edge=False)
        for head in ("transits", "", *(f"std {name}" for name in foresight.targets)):
            table.add_column(head, justify="left" if head == "" else "right")
        for row in foresight.rows():
            stds = (f"{row[f'std {name}']:.2g}" for name in foresight.targets)
            table.add_row(str(row["transits"]), row["excursion"], *stds)
        console.print(table)
    for note in foresight.notes:
        console.print(f"- {note}", style="dim")


def foresight_figure(foresight: Foresight) -> Figure:
    """Draw standard errors by the number of transits, a line a kind."""
    targets = foresight.targets
    figure, axes = panels(1, len(targets), 3.6, Margins(bottom=1.35, top=0.25, across=0.75))
    for panel, name in zip(axes[0], targets, strict=True):
        panel.axhline(foresight.prior_std[name], color=GREY, ls="--", label="now")
        for number, kind in enumerate(foresight.kinds):
            style = DASHES[number % len(DASHES)]
            panel.plot(foresight.transits, kind.std[name], color=COLOURS[number % len(COLOURS)], ls=style, marker="o",
                       ms=3, label=kind.excursion.words)  # fmt: skip
        panel.set(xscale="log", xlabel="transits", ylabel=f"standard error of {name}")
        panel.set_xticks(foresight.transits, [str(count) for count in foresight.transits])
        panel.minorticks_off()
        panel.set_ylim(bottom=0)
        panel.grid(alpha=0.3)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=1 + (len(labels) > 3), frameon=False, fontsize=7)
    return figure
