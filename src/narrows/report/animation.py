"""An animation of a voyage: the ship between its banks."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import FuncAnimation, PillowWriter

from narrows.errors import InputError, shown
from narrows.files import form_of, write_whole
from narrows.report.style import BLUE, FONT, WIDTH, Picture, titled
from narrows.report.voyage_figures import banks_on, hull
from narrows.simulation.voyage import Voyage

FRAMES_A_SECOND = 15
LONGEST = 120.0  # Longest animation [s]
LENGTHS = 3.0  # Visible distance ahead and astern [ship lengths]


def animation_of(voyage: Voyage, path: str | Path | None = None, seconds: float = 8.0) -> FuncAnimation:
    """Make an animation of a voyage in its canal, and write it if a path is given."""
    if not 0 < seconds <= LONGEST:
        raise InputError(f"seconds = {shown(seconds)}: give the length of a film, up to {LONGEST:g} s")
    form = None if path is None else form_of(path, (".gif", ".html"))
    film = _film(voyage, max(2, round(FRAMES_A_SECOND * seconds)))
    if path is not None:
        with TemporaryDirectory() as folder:
            if form == ".gif":
                film.save(Path(folder) / "film.gif", writer=PillowWriter(fps=FRAMES_A_SECOND))
            made = film.to_jshtml(FRAMES_A_SECOND) if form == ".html" else (Path(folder) / "film.gif").read_bytes()
        write_whole(path, made)
    return film


def _film(voyage: Voyage, frames: int) -> FuncAnimation:
    length = voyage.configuration.ship.length
    near, far = float(voyage.x.min()) - length, float(voyage.x.max()) + 2 * LENGTHS * length
    with rc_context(FONT):
        figure = Picture(figsize=(WIDTH, 3.4), layout="constrained")
        axes = figure.subplots()
        half = banks_on(axes, near, far, voyage)
        axes.set(ylim=(half * 1.12, -half * 1.12), aspect="equal")
        axes.set(xlabel="along the canal x [m], starboard down", ylabel="y [m]")
        (path,) = axes.plot([], [], color=BLUE, linewidth=1.0)
        ship = hull(voyage, 0, BLUE)
        axes.add_patch(ship)
    rows = np.searchsorted(voyage.t, np.linspace(voyage.t[0], voyage.t[-1], frames)).clip(max=len(voyage) - 1)

    def show(row: int) -> tuple[Any, ...]:
        ship.set_xy(hull(voyage, row, BLUE).get_xy())
        path.set_data(voyage.x[: row + 1], voyage.y[: row + 1])
        left = max(near, float(voyage.x[row]) - LENGTHS * length)
        axes.set_xlim(left, left + 2 * LENGTHS * length)
        titled(axes, [f"{voyage.t[row]:.1f} s" if row < len(voyage) - 1 else voyage.outcome.sentence])
        return path, ship

    return FuncAnimation(figure, show, frames=rows.tolist(), interval=1000 / FRAMES_A_SECOND)
