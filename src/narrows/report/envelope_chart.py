"""The chart that a pilot would pin up: safe speeds in knots over offsets in metres, rudder angles in degrees."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from narrows.model.model import Model
from narrows.quantities.constants import KNOT
from narrows.report.style import BLACK, BLUE, DASHES, GREY, ORANGE, PURPLE, panels
from narrows.safety import FIVE_PERCENT, MEDIAN, RESERVE, SafeEnvelope

PALE, PALER = "#A9CFE8", "#DCEBF5"


def envelope_chart(envelope: SafeEnvelope, model: Model, reserve: float = RESERVE) -> Figure:
    """Draw the safe envelope: speeds above, rudder angles below, the banks on either side (ours).

    Parameters
    ----------
    envelope : SafeEnvelope
        What to draw.
    model : Model
        The ship in her canal.
    reserve : float [1]
        Of the rudder.
    """
    figure, axes = panels(2, 1, 7.0, sharex=True, height_ratios=(3, 2))
    speeds, rudder = axes[:, 0]
    _draw_speeds(speeds, envelope, model)
    _draw_rudder(rudder, envelope, model, reserve)
    for own in (speeds, rudder):
        _draw_banks(own, envelope, model)
    figure.suptitle(f"Safe envelope: {envelope.description}", fontsize=9.5)
    return figure


def _draw_speeds(axes: Axes, envelope: SafeEnvelope, model: Model) -> None:
    """Each colour reaches from one offset that is safe to the next, and no farther; a safe one alone is its line."""
    y, u = envelope.data["y"].to_numpy(), envelope.data["u"].to_numpy() / KNOT
    for share, colour, dash in ((MEDIAN, PALER, "--"), (FIVE_PERCENT, PALE, "-")):
        low, high = (own(share).to_numpy() / KNOT for own in (envelope.lowest_speed, envelope.highest_speed))
        axes.fill_between(y, low, high, where=np.isfinite(high), color=colour, lw=0)
        for edge in (low, high):
            axes.plot(y, edge, color=BLACK, ls=dash, lw=1.8 * share, marker=".", markersize=3)
        axes.vlines(y[_ends_of_runs(high)], low[_ends_of_runs(high)], high[_ends_of_runs(high)], color=BLACK, ls=dash,
                    lw=1.8 * share)  # fmt: skip
    blocked = u[~envelope.data["clear"].to_numpy()]
    step = (u[-1] - u[0]) / max(len(u) - 1, 1) or 1.0
    if blocked.size:
        axes.axhspan(blocked.min() - step / 2, u[-1] + step / 2, facecolor="none", edgecolor=ORANGE, hatch="///", lw=0)
    _draw_tested(axes, model)
    axes.set_ylabel("speed through the water [knots]")
    axes.set_ylim(u[0] - step / 2, u[-1] + step / 2)
    axes.legend(
        handles=_speed_legend(bool(blocked.size)), loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False, ncols=2
    )
    axes.grid(alpha=0.3)


def _ends_of_runs(high: np.ndarray) -> np.ndarray:
    """Places where safe offsets begin or end."""
    safe = np.isfinite(high)
    around = np.concatenate([[False], safe, [False]])
    return np.flatnonzero(safe & ~(around[:-2] & around[2:]))


def _draw_tested(axes: Axes, model: Model) -> None:
    """The offsets and speeds that the tests covered, at this size."""
    speed, offset = model.data_range.speed, model.data_range.abs_y
    for side in () if offset is None else (-offset[1], offset[1]):
        axes.axvline(side, color=PURPLE, ls=":", lw=1.4)
    if speed is not None:
        axes.axhline(speed[1] / KNOT, color=PURPLE, ls=":", lw=1.4)


def _speed_legend(blocked: bool) -> list[Patch | Line2D]:
    handles: list[Patch | Line2D] = [
        Patch(facecolor=PALE, edgecolor=BLACK, lw=1.7, label="safe in 95 % of the samples (the 5 % line)"),
        Patch(facecolor=PALER, edgecolor=BLACK, ls="--", label="safe in half of them"),
        Line2D([], [], color=PURPLE, ls=":", label="as far as the tests went"),
    ]
    if blocked:
        handles.append(Patch(facecolor="none", edgecolor=ORANGE, hatch="///", label="keel or choked canal"))
    return handles


def _draw_rudder(axes: Axes, envelope: SafeEnvelope, model: Model, reserve: float) -> None:
    limit = model.configuration.gear.limit_deg
    data, y = envelope.data, envelope.data["y"].to_numpy()
    sailed = np.flatnonzero(data["clear"].to_numpy() | ~data["clear"].to_numpy().any())
    ends = np.unique(sailed[[0, -1]])[:: -1 if envelope.speed_free else 1]
    for style, place in zip(DASHES, ends[: 1 if envelope.speed_free else None].tolist(), strict=False):
        own = data.isel(u=place)
        label = "at every speed" if envelope.speed_free else f"at {float(own['u']) / KNOT:.1f} knots"
        axes.plot(y, np.degrees(own["rudder"]), color=BLUE, ls=style, label=f"median, {label}")
        for name, said in (("rudder_low", f"90 % of the samples, {label}"), ("rudder_high", None)):
            axes.plot(y, np.degrees(own[name].where(np.isfinite(own[name]))), color=ORANGE, ls=style, label=said)
    for sign in (1, -1):
        axes.axhline(sign * limit, color=BLACK, lw=1.4)
        axes.axhline(sign * limit * (1 - reserve), color=GREY, lw=1.0, ls="--")
    axes.text(
        0.01, limit * (1 - reserve), " reserve begins", transform=axes.get_yaxis_transform(), va="bottom", color=GREY
    )
    axes.text(0.01, limit, " hard over", transform=axes.get_yaxis_transform(), va="bottom")
    axes.set_ylim(-1.2 * limit, 1.2 * limit)
    axes.set_ylabel("rudder that holds her [deg]\npositive turns the bow to starboard")
    axes.set_xlabel("offset from the middle [m]: port is negative, starboard positive")
    axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2)
    axes.grid(alpha=0.3)


def _draw_banks(axes: Axes, envelope: SafeEnvelope, model: Model) -> None:
    """Where her keel meets the banks in black, and in grey where the middle of the ship cannot be for her own side."""
    side, (port, starboard) = model.configuration.ship.beam / 2, envelope.walls
    for sign, wall in ((-1, port), (1, starboard)):
        axes.axvspan(sign * (wall - side), sign * wall, color=GREY, alpha=0.35, lw=0)
        axes.axvline(sign * wall, color=BLACK, lw=3)
    axes.set_xlim(-1.02 * port, 1.02 * starboard)
