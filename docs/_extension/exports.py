"""Models as files to take along: FMUs, C, pages, made in the build and committed by nobody."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import narrows as nw
from narrows.model.sections import Source
from narrows.model.tables import table_named

FOLDER = "_static/ready"
BORROWED = "borrowed from the DTC"
CANAL, SPEED = 14.0, 0.8
"""Of the KVLCC2: a canal [m] of eleven beams, and a speed [m/s] at which a helm holds it there."""


def paper() -> nw.Model:
    """The published DTC."""
    return nw.published("mikkelsen2025_dtc")


def banked() -> nw.Model:
    """The published KVLCC2 between the banks of a canal: it says itself that the bank's coefficients are borrowed."""
    published, dtc = nw.published("yasukawa2015_kvlcc2"), paper()
    borrowed = {"Y_bank": dtc["b_bank"], "N_bank": dtc["c_bank"]}
    source = Source(f"{published.source.text}; the coefficients of the bank {BORROWED}")
    return nw.Model(
        replace(published.configuration, canal=nw.Canal(CANAL)), table_named("mmg+delta"),
        {**published.coefficients, **borrowed}, source=source, verdicts=dict.fromkeys(borrowed, BORROWED),
    )  # fmt: skip


FILES: dict[str, Callable[[Path], object]] = {
    "dtc.html": lambda path: nw.export.write(paper(), path, title="DTC, a model of a container ship, in a canal"),
    "dtc.fmu": lambda path: nw.export.write(paper(), path),
    "dtc.h": lambda path: nw.export.write(paper(), path),
    "kvlcc2.html": lambda path: nw.export.write(
        banked(), path, title="KVLCC2, a model of a tanker, in a canal; switch the helm on", u=SPEED
    ),
    "kvlcc2.fmu": lambda path: nw.export.write(banked(), path, u=SPEED),
    "kvlcc2.h": lambda path: nw.export.write(banked(), path),
}


def write_all(source: Path, written: bool = True) -> None:
    """Write all files anew, or put empty ones where nothing is."""
    folder = Path(source) / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for name, write in FILES.items():
        if written:
            write(folder / name)
        else:
            (folder / name).touch()
