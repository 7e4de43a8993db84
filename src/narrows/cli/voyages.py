"""``simulate``, ``map``, ``trials`` and ``waterway``, with their groups of options: start, helm, time, water."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import radians
from pathlib import Path
from typing import Annotated, Any

import click
import numpy as np

import narrows as nw
import narrows.report.printed_tables as tables
from narrows.base.errors import InputError, check_choice
from narrows.base.files import save_dataset
from narrows.cli import options as cli
from narrows.empirical.fleet import model_named

ContactKind = Annotated[str, "Contact with the bank: hull 'corners', 'midship' clearance, or 'none' in open water."]


@dataclass(frozen=True)
class StartOptions:
    y: Annotated[float, "Start to starboard of the centreline [m]."] = 0.0
    speed: Annotated[cli.Speed | None, "Surge velocity: 1.2 [m/s] or 8kn; default: one that suits the ship."] = None
    psi_deg: Annotated[float, "Heading at the start [deg]."] = 0.0
    v: Annotated[cli.Speed, "Sway velocity at the start, likewise."] = "0m/s"
    r_deg: Annotated[float, "Yaw rate at the start [deg/s]."] = 0.0
    x: Annotated[float, "Start along the canal [m]."] = 0.0
    revolutions: Annotated[float | None, "Propeller revolutions [1/s]; default: those of the model."] = None

    def values(self) -> dict[str, float]:
        turning = {"psi": radians(self.psi_deg), "r": radians(self.r_deg)}
        turns = {} if self.revolutions is None else {"revolutions": self.revolutions}
        return {"x": self.x, "y": self.y, "v": self.v, **turning, **turns}


@dataclass(frozen=True)
class TimeOptions:
    duration: Annotated[float | None, "Longest duration of a voyage [s]; default: the time of 15 ship lengths."] = None
    dt: Annotated[float | None, "Time step [s]; default: a 200th of the time of a ship length."] = None


@dataclass(frozen=True)
class PhysicsOptions:
    surge: Annotated[str, "'held': constant speed; 'free': it is integrated."] = "held"
    surge_inertia: Annotated[float | None, "Mass in surge with its added mass [kg], for 'free'."] = None
    coriolis: Annotated[bool, "Add the rigid body's Coriolis force."] = False
    contact: ContactKind = "corners"


def read_current(
    option: str, text: str, read: Callable[[str, str], float] = cli.speed
) -> float | list[tuple[float, float]]:
    """Read the speed of a current [m/s], or pairs of a place [m] and the speed there: ``0:0.4m/s,2000:1m/s``."""
    if ":" not in text:
        return read(option, text)
    pairs = [pair.partition(":") for pair in text.split(",")]
    return [(_number(option, place), read(option, number)) for place, _, number in pairs]


def _number(option: str, text: str) -> float:
    return float(cli.numbers(option, text, "0.002, or 0:0.001,900:0, without a unit")[0])


Current = Annotated[Any, read_current]
Shear = Annotated[Any, partial(read_current, read=_number)]
CurrentText = Annotated[Current, "Current along the waterway at its beginning: 0.5m/s, 1kn; or 0:0.5m/s,900:1m/s."]


@dataclass(frozen=True)
class WaterOptions:
    waterway: cli.WaterwayFile = None
    current: CurrentText = None
    level: Annotated[float | None, "Water level above that of the waterway's depths [m]."] = None
    current_across: Annotated[Current, "Current to starboard of the line, likewise."] = None
    current_shear: Annotated[Shear, "Rise of the current per metre to starboard [1/s]: 0.002; 0:0.001,900:0."] = None

    def read(self) -> "nw.Waterway | None":
        if self.waterway is None:
            return None
        water = (self.current, self.level, self.current_across, self.current_shear)
        return nw.read_waterway(self.waterway).with_water(*water)


OF_WATERWAY = {"current level current_across current_shear": "waterway"}


@dataclass(frozen=True)
class VariedOptions:
    y: Annotated[cli.Numbers | None, "Start to starboard [m]: a,b,c or from:to:count; default: bank to bank."] = None
    speed: Annotated[cli.Speeds | None, "Surge velocity: 1.2 [m/s], 8kn, 4kn:8kn:5; default: suits the ship."] = None
    psi_deg: Annotated[cli.Numbers, "Heading at the start [deg], likewise."] = "0"
    width: Annotated[cli.Numbers | None, "Canal width [m], likewise; default: the model's own."] = None
    x: Annotated[cli.Numbers, "Start along the waterway [m], likewise."] = "0"

    def values(self, model: "nw.Model") -> dict[str, Any]:
        from narrows.simulation.initial_state import voyage_defaults

        defaults = voyage_defaults(model, self.speed)
        aside = np.linspace(-defaults.offset, defaults.offset, OFFSETS)
        vary = {
            "y": aside if self.y is None else self.y,
            "u": np.array([defaults.speed]) if self.speed is None else self.speed,
            "psi": radians(1) * self.psi_deg, "x": self.x, **({} if self.width is None else {"width": self.width}),
        }  # fmt: skip
        return {name: values if values.size > 1 else float(values[0]) for name, values in vary.items()}


BOTTOM = cli.Option("--bottom/--no-bottom", help="End where the ship touches bottom or chokes the section.")
# Distance below which two places are one in words [m].
SAME_PLACE = 0.05
# Default number of offsets in a map.
OFFSETS = 101


@cli.verb(
    "narrows simulate mikkelsen2025_dtc --y 0.5 --speed 1m/s -o voyage.nc --plot voyage.png",
    needs=OF_WATERWAY | {"controller": "hold"},
)
def simulate(
    model: cli.ModelFile,
    start: StartOptions,
    time: TimeOptions,
    physics: PhysicsOptions,
    water: WaterOptions,
    delivery: cli.TrackDelivery,
    rudder_deg: Annotated[float, "Rudder angle [deg], positive to starboard; for models with a rudder."] = 0.0,
    hold: Annotated[float | None, "Offset held by a helm [m], for models with a rudder."] = None,
    controller: Annotated[str | None, "Helm: regulator or predictive."] = None,
    bottom: Annotated[bool, BOTTOM] = True,
) -> None:
    """Simulate one voyage, to where the ship grounds."""
    from narrows.simulation.initial_state import voyage_defaults

    chosen, waterway = model_named(model), water.read()
    u = voyage_defaults(chosen).speed if start.speed is None else start.speed
    options: dict[str, Any] = start.values() | vars(time) | vars(physics) | {"bottom": bottom, "hold": hold}
    if controller is not None:
        check_choice("--controller", controller, ("regulator", "predictive"))
    if controller == "predictive" and hold is not None:
        options |= {"hold": None, "controller": nw.control.PredictiveHelm(chosen, hold, u, waterway)}
    voyage = nw.simulate(chosen, u=u, rudder=radians(rudder_deg), waterway=waterway, **options)
    unsteered = hold is None and any(actuator.name == "rudder" for actuator in chosen.terms.actuators)
    fixed = f"\nNobody steered: the rudder stayed at {rudder_deg:g} degrees; --hold 0 steers along y = 0." * unsteered
    delivery.give(voyage, lambda voyage: click.echo(voyage.summary() + fixed))
    raise SystemExit(int(voyage.outcome.kind == "diverged"))


@cli.verb(
    "narrows map mikkelsen2025_dtc --y -2.5:2.5:101 --speed 0.6:1.2:61 --plot map.png", "map",
    needs=OF_WATERWAY | {"within": "samples"},
)  # fmt: skip
def map_(
    model: cli.ModelFile,
    varied: VariedOptions,
    time: TimeOptions,
    water: WaterOptions,
    delivery: cli.DatasetDelivery,
    samples: Annotated[int, "Number of coefficient samples from the fit's covariance."] = 0,
    within: Annotated[float | None, "With --samples: map the probability of grounding within a distance [m]."] = None,
    seed: Annotated[int, "Seed of the samples."] = 0,
    contact: ContactKind = "corners",
) -> None:
    """Map where the ship grounds, over one or two variables."""
    from narrows.simulation.ensemble import map_summary

    if within is not None and not 0 < within < float("inf"):
        raise InputError(f"--within {within} is no distance; give metres")
    chosen, waterway = model_named(model), water.read()
    vary: dict[str, Any] = varied.values(chosen)
    voyages = nw.ensemble(
        chosen, samples=samples, seed=seed, waterway=waterway,
        progress=sys.stderr.isatty() and not delivery.json, **vars(time) | {"contact": contact}, **vary,
    )  # fmt: skip
    summary = map_summary(voyages)
    delivery.give(
        summary, lambda summary: click.echo(summary["summary"]), save=lambda path: save_dataset(voyages, path),
        draw=lambda: nw.report.map_figure(voyages, chosen, within, waterway, vary), values=lambda: summary,
    )  # fmt: skip
    raise SystemExit(int(summary["outcomes"]["diverged"] == summary["voyages"]))


def _zigzags(option: str, text: str) -> tuple[tuple[float, float], ...]:
    try:
        pairs = [word.split("/") if "/" in word else [word] * 2 for word in text.split(",") if word]
        return tuple((float(rudder), float(heading)) for rudder, heading in pairs)
    except ValueError:
        raise InputError(
            f"{option} {text!r} is not understood; write rudder/heading in degrees, such as 10/10,20/20"
        ) from None


Zigzags = Annotated[Any, _zigzags]


@cli.verb("narrows trials yasukawa2015_kvlcc2 --speed 1.179m/s --plot tracks.png")
def trials(
    model: cli.ModelFile,
    speed: Annotated[cli.Speed, "Approach speed: 1.2m/s, 8kn; m/s without a unit."],
    delivery: cli.ChartDelivery,
    turn_deg: Annotated[float, "Rudder angle of the turning circles, to either side [deg]."] = 35.0,
    zigzags: Annotated[Zigzags, "Rudder/heading of the zigzags [deg], a/b,c/d; 10 is 10/10."] = "10/10,20/20",
    dt: Annotated[float | None, "Time step [s]; default: a 120th of the time of a ship length."] = None,
) -> None:
    """Simulate turning circles and zigzags in open water.

    It gives advance, tactical diameter and overshoots of a model with a rudder, without its terms of the banks.
    """
    if small := [angle for angle in (turn_deg, *sum(zigzags, ())) if 0 < abs(angle) < 1]:
        raise InputError(f"trials at {small[0]:g} degrees turn no ship; give degrees from 1, or --turn-deg 0.6rad")
    result = nw.sail_trials(model_named(model), speed, turn_deg, zigzags, dt)
    delivery.give(result, tables.print_manoeuvres)


@cli.verb("narrows linearize estimated_kcs --y 20 --speed 4m/s")
def linearize(
    model: cli.ModelFile,
    delivery: cli.TableDelivery,
    y: Annotated[float, "Offset of the steady course to starboard of the centreline [m]."] = 0.0,
    speed: Annotated[cli.Speed | None, "Surge velocity: 1.2 [m/s] or 8kn; default: one that suits the ship."] = None,
) -> None:
    """Linearise the motion about a steady course: modes, and matrices in the table or JSON."""
    from narrows.simulation.initial_state import voyage_defaults

    ship = model_named(model)
    u = voyage_defaults(ship).speed if speed is None else speed
    delivery.give(nw.control.linearize(ship, y, u), tables.print_linear)


@cli.verb("narrows squat estimated_kcs --speed 6kn:12kn:7")
def squat(
    model: cli.ModelFile,
    speed: Annotated[cli.Speeds, "Speed through the water: 8kn, or 4kn:12kn:9; m/s without a unit."],
    delivery: cli.TableDelivery,
    gives: Annotated[str | None, "Place: midship, bow or largest; default: midship, or that of the formula."] = None,
    formula: Annotated[str | None, "Formula: huuska, icorels, barrass ...; default: the first that is valid."] = None,
) -> None:
    """Estimate the sinkage of a ship in its canal."""
    choice: Any = gives, formula
    delivery.give(nw.squat(model_named(model), speed, *choice), tables.print_squat)


@cli.verb(
    "narrows waterway --line axis.geojson --width 300 --depth 16 -o canal.geojson",
    needs={"reach": "line"}, apart=("file width", "reach width"),
)  # fmt: skip
def waterway(
    file: Annotated[Path | None, cli.Argument(help="GeoJSON, KML, shapefile, chart (.000); none with --width.")] = None,
    line: Annotated[Path | None, "Centreline as it is sailed, through a chart: a map with one line."] = None,
    width: Annotated[float | None, "Width from bank to bank along --line [m]."] = None,
    depth: Annotated[float | None, "Water depth [m], if the file gives none."] = None,
    reach: Annotated[float, "Search distance for a bank in a chart [m]."] = 1000.0,
    draft: Annotated[float, "Draft of a ship [m]: the width is then that available to the keel."] = 0.0,
    delivery: cli.WaterwayDelivery = cli.Delivery(),
) -> None:
    """Make or check a waterway file.

    The source is a line with a width and a depth, a chart, or a GeoJSON file.
    """
    if file is not None and file.suffix == ".000" and line is None:
        raise InputError("a chart (.000) goes with --line, its centreline on a map with one line")
    if not 0 <= draft < 1000:
        raise InputError(f"--draft {draft} is invalid; give metres from 0 to 1000")
    result, notes = _made(file, line, width, depth, reach)
    delivery.give(
        result, lambda result: tables.print_waterway(result, draft, notes),
        save=lambda path: nw.write_waterway(result, path), values=lambda: tables.waterway_summary(result, draft, notes),
    )  # fmt: skip


def _made(
    file: Path | None, line: Path | None, width: float | None, depth: float | None, reach: float
) -> tuple["nw.Waterway", tuple[str, ...]]:
    """Return the waterway of a file, of a line with a width, or of a chart along a line, with notes."""
    from narrows.waterway.geojson import farthest, read_line, waterway_from_line

    if file is None:
        if line is None or width is None or depth is None:
            raise InputError("give a file, or --line axis.geojson --width 300 --depth 16 to make a canal of one width")
        result = waterway_from_line(points := read_line(line), width, depth, line.stem)
        moved = farthest(result, points)
        smoothed = (f"the line is smoothed, by up to {moved:.1f} m: as drawn it bends inside its banks",)
        return result, smoothed * bool(moved > SAME_PLACE)
    if line is None:
        return nw.read_waterway(file, depth=depth), ()
    from narrows.waterway.map_lines import read_chart, waterway_from_chart

    return waterway_from_chart(read_chart(file), read_line(line), reach), ()
