"""Pictures of estimates: states with their band of 95 %, and how well the band holds on twins."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.estimation.consistency import Consistency
from narrows.estimation.estimate import EstimatedTrack
from narrows.estimation.states import STATES
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, notes_below, panels

IN_DEGREES = {"rad": ("deg", 180.0 / np.pi), "rad/s": ("deg/s", 180.0 / np.pi)}
SHOWN = ("y", "psi", "v", "bank", "current", "current_across", "rudder_bias", "heading_bias")
NORMAL_95 = 1.959964


def track_figure(track: EstimatedTrack, truth: np.ndarray | None = None) -> Figure:
    """Draw states over time with their band of 95 %, and where sensors were refused or suspected."""
    # truth (times, states)
    names = [name for name in SHOWN if name in track.states]
    first = int(truth is not None)
    figure, axes = panels(first + len(names), 1, 1.1 + 0.95 * (first + len(names)), sharex=True)
    if truth is not None:
        _error(axes[0, 0], track, truth)
    for axis, name in zip(axes[first:, 0], names, strict=True):
        _state(axis, track, name, None if truth is None else truth[:, track.states.index(name)])
    for axis in axes[:, 0]:
        axis.grid(alpha=0.3)
        _mark(axis, track)
    handles, labels = axes[first, 0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, ncols=4, loc="outside upper left")
    axes[-1, 0].set_xlabel("time [s]")
    notes_below(figure, track.notes)
    return figure


def _state(axis: Axes, track: EstimatedTrack, name: str, truth: np.ndarray | None) -> None:
    place = track.states.index(name)
    unit, factor = IN_DEGREES.get(STATES[name][0], (STATES[name][0], 1.0))
    mean, wide = factor * track.mean[:, place], NORMAL_95 * factor * track.std[:, place]
    axis.fill_between(track.t, mean - wide, mean + wide, color=BLUE, alpha=0.25, linewidth=0, label="95 % band")
    axis.plot(track.t, mean, color=BLUE, label="estimate")
    if truth is not None:
        axis.plot(track.t, factor * truth, color=BLACK, linestyle="--", linewidth=1.0, label="truth")
    axis.set_ylabel(f"{name.replace('_', chr(10))} [{unit}]", fontsize=8)


def _error(axis: Axes, track: EstimatedTrack, truth: np.ndarray) -> None:
    place = track.states.index("y")
    wide = NORMAL_95 * track.std[:, place]
    axis.fill_between(track.t, -wide, wide, color=BLUE, alpha=0.25, linewidth=0)
    axis.plot(track.t, track.mean[:, place] - truth[:, place], color=BLUE)
    axis.set_ylabel("error of y [m]", fontsize=8)


def _mark(axis: Axes, track: EstimatedTrack) -> None:
    """Shade where sensors were refused, and hatch where they were suspected."""
    looks = ((track.refused, ORANGE, "", "refused"), (track.suspected, GREY, "///", "suspected"))
    for flags, colour, hatch, what in looks:
        for name, flag in flags.items():
            if flag.any():
                axis.fill_between(
                    track.t, 0, 1, where=flag.tolist(), transform=axis.get_xaxis_transform(), color=colour, alpha=0.25,
                    hatch=hatch, linewidth=0, step="mid", label=f"{name} {what}",
                )  # fmt: skip


def consistency_figure(result: Consistency) -> Figure:
    """Draw the mean NEES of the twins over time within its bounds, and the errors of each state over their band."""
    figure, axes = panels(1, 2, 2.8)
    left, right = axes[0]
    mean = np.nanmean(result.nees[:, result.counted], axis=0) / len(result.states)
    low, high = result.bounds()
    left.axhspan(low, high, color=BLUE, alpha=0.2, linewidth=0, label="95 % by chance")
    left.plot(result.t[result.counted], mean, color=BLUE, label=f"mean of {len(result.nees)} twins")
    left.set(xlabel="time [s]", ylabel=f"NEES of {len(result.states)} states over {len(result.states)} [1]")
    left.legend(frameon=False)
    covered = result.covered
    right.barh([name.replace("_", " ") for name in covered], list(covered.values()), color=BLUE)
    right.axvline(0.95, color=BLACK, linestyle="--", linewidth=1.0)
    right.set(xlabel="errors within the 95 % band [1]", xlim=(0.0, 1.0))
    right.invert_yaxis()
    for axis in (left, right):
        axis.grid(alpha=0.3)
    notes_below(figure, result.notes)
    return figure
