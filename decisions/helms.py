"""Five scenes under three helms: the table of docs/benchmarks.md, and its picture, which `make docs` draws.

Sampling predictive control (a few hundred random plans a step about the linear-quadratic loop, the best ones weighed)
was tried on the same scenes: it held as many as predictive control by a quadratic program, with four times the rudder.
It is left out.

python decisions/helms.py [--write]
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from pages import Rows, markdown, publish, records

import narrows as nw

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))
import helm_scenes
from clairvoyant import unsaved
from scenes.five_scenes import DURATION, SPEED, Scene, scenes
from scenes.fleet import Fleet
from scenes.helms import HELMS

TRUTHS = 1000
HEADER = (
    "scene", "helm", "median largest deviation [m]", "rudder travel [degrees]", "aground of 1000", "lost of 1000",
    "lost under the best rudder", "lost of 1000 with half the standard deviations",
)  # fmt: skip
COLOURS = {"track": "#d55e00", "regulator": "#0072b2"}
LABELS = {"track": "track pilot", "regulator": "regulator"}


def text(chosen: tuple[str, ...] = ()) -> str:
    """Each scene, or those chosen, under each helm."""
    model = helm_scenes.full_scale()
    now, better = (helm_scenes.flown(model, TRUTHS, chosen, spread) for spread in helm_scenes.SPREADS)
    rows = []
    for (scene, helm), row in now.items():
        lost = (row["aground"], row["lost"], better[scene, helm]["lost"])
        aground, now_lost, better_lost = (f"{1000 * share:.0f}" for share in lost)
        bound = f"{1000 * best_rudder(model, scene):.0f}" if helm == "regulator" else ""
        moved = (f"{row['deviation']:.1f}", f"{row['travel']:.0f}")
        rows.append((scene, helm, *moved, aground, now_lost, bound, better_lost))
    return markdown(HEADER, rows)


def shown(rows: Rows) -> str:
    """A row a scene: how many ships each helm loses."""
    helms, lost = ("track", "regulator", "regulator that knows the ship"), "lost of 1000"
    found = {(row["scene"], row["helm"]): row for row in records(rows, "scene")}
    heads = (
        "scene",
        "track pilot",
        "regulator",
        "with the true coefficients",
        "best rudder",
        "regulator, intervals halved",
    )
    lines = []
    for scene in dict.fromkeys(scene for scene, _ in found):
        own = found[scene, "regulator"]
        last = own["lost under the best rudder"], own[HEADER[-1]]
        lines.append((scene, *(found[scene, helm][lost] for helm in helms), *last))
    return markdown(heads, lines)


def best_rudder(model: nw.Model, name: str) -> float:
    """Share of the ships lost by the regulator that no rudder saves, of all ships."""
    scene = scenes(model)[name]
    fleet = Fleet(model, TRUTHS, waterway=scene.waterway)
    helm_scenes.fly(fleet, scene, HELMS["regulator"](fleet, scene))
    return unsaved(fleet, scene) / TRUTHS


def voyage(model: nw.Model, scene: Scene, helm: str) -> nw.Voyage:
    """The mean ship through a scene."""
    course = {
        name: float(value) for name, value in nw.control.linearize(model, scene.lines[0][1], SPEED).course.items()
    }
    times = np.arange(0.0, DURATION)
    pushes = np.array([scene.push(t) for t in times])
    changes = np.flatnonzero(np.r_[True, (np.diff(pushes, axis=0) != 0).any(axis=1)])
    forces = {name: [(times[k], pushes[k, i]) for k in changes] for i, name in enumerate("YN")}
    asked = HELMS[helm](Fleet(model, 1), scene)
    law = asked[-1][1] if isinstance(asked, list) else asked
    if isinstance(asked, list) and len(asked) > 1:
        law = _in_turn(asked)
    told = {name: course[name] for name in ("y", "u", "psi", "v", "rudder")}
    return nw.simulate(
        model, **told, x=200.0, duration=DURATION, dt=1.0, controller=law, waterway=scene.waterway, **forces
    )


def _in_turn(pilots: list[tuple[float, nw.Autopilot]]) -> object:
    """Track pilots, each from its time on, as a function of time and state."""

    def order(t: float, state: object) -> float:
        own = [pilot for start, pilot in pilots if start <= t + 1e-9][-1]
        off = [getattr(state, name) - at for name, at in (("y", own.y), ("psi", own.psi), ("v", own.v), ("r", 0.0))]
        return float(own.rudder - np.dot(own.gains, off))

    return order


@rc_context({"font.size": 8.0, "axes.titlesize": 9.0})
def figure() -> Figure:
    """Offset, heading, rudder and the clearance to the nearer bank, a column for each scene."""
    model = helm_scenes.full_scale()
    shown, ship = scenes(model), model.configuration.ship
    drawn = Figure(figsize=(9.0, 6.8), layout="constrained")
    axes = drawn.subplots(4, len(shown), sharex=True)
    for column, (name, scene) in enumerate(shown.items()):
        axes[0, column].set_title(name)
        times = np.arange(0.0, DURATION)
        axes[0, column].plot(times, [scene.wanted(t) for t in times], color="0.6", linewidth=0.8)
        for helm, colour in COLOURS.items():
            flown = voyage(model, scene, helm)
            reach = ship.length / 2 * np.abs(np.sin(flown.psi)) + ship.beam / 2 * np.cos(flown.psi)
            clearance = model.configuration.canal.width / 2 - np.abs(flown.y) - reach
            for row, values in enumerate((flown.y, np.degrees(flown.psi), np.degrees(flown.rudder), clearance)):
                axes[row, column].plot(flown.t, values, color=colour, linewidth=1.0, label=LABELS[helm])
        axes[3, column].set_xlabel("time [s]")
    for row, label in enumerate(("offset [m]", "heading [deg]", "rudder [deg]", "clearance [m]")):
        axes[row, 0].set_ylabel(label)
    for panel in axes.ravel():
        panel.grid(alpha=0.3)
    drawn.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
    return drawn


if __name__ == "__main__":
    publish(__file__, "benchmarks.md", text(), shown)
