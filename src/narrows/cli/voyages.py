"""``simulate`` and ``map``: where, when and on which side a ship grounds."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from narrows.cli.app import app
from narrows.cli.options import (
    AsJson,
    ContactKind,
    Coriolis,
    Current,
    DatasetOutput,
    Duration,
    Level,
    ModelFile,
    Plot,
    Surge,
    SurgeInertia,
    TimeStep,
    TrackOutput,
    WaterwayFile,
)
from narrows.cli.output import print_json, say_written
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.model.model import Model
    from narrows.simulation.usual import UsualVoyage
    from narrows.waterway import Waterway

HELMS = ("regulator", "predictive", "track")
OFFSETS = 101
"""Of a map, where none are given."""


@app.command(epilog="Example: narrows simulate mikkelsen2025_dtc --y 0.5 --speed 1m/s -o voyage.nc --plot voyage.png")
def simulate(
    model: ModelFile,
    y: Annotated[float, typer.Option(help="Start to starboard of the centreline [m].")] = 0.0,
    speed: Annotated[
        str | None,
        typer.Option(help="Surge velocity: 1.2m/s, 8kn; m/s without a unit; as suits the ship unless given."),
    ] = None,
    psi_deg: Annotated[float, typer.Option(help="Heading at the start [deg].")] = 0.0,
    v: Annotated[str, typer.Option(help="Sway velocity at the start, likewise.")] = "0m/s",
    r_deg: Annotated[float, typer.Option(help="Yaw rate at the start [deg/s].")] = 0.0,
    surge_force: Annotated[float, typer.Option("--X", help="Surge force from elsewhere [N].")] = 0.0,
    sway_force: Annotated[float, typer.Option("--Y", help="Sway force from elsewhere [N].")] = 0.0,
    yaw_moment: Annotated[float, typer.Option("--N", help="Yaw moment from elsewhere [N m].")] = 0.0,
    rudder_deg: Annotated[
        float, typer.Option(help="Rudder angle [deg], positive to starboard; if terms know it.")
    ] = 0.0,
    hold: Annotated[float | None, typer.Option(help="Offset that a helm holds [m], for models with a rudder.")] = None,
    controller: Annotated[
        str | None, typer.Option(help="That helm: regulator, predictive, or track for the one without an integral.")
    ] = None,
    duration: Duration = None,
    dt: TimeStep = None,
    surge: Surge = "held",
    surge_inertia: SurgeInertia = None,
    coriolis: Coriolis = False,
    contact: ContactKind = "corners",
    waterway: WaterwayFile = None,
    x: Annotated[float, typer.Option(help="Start along the canal [m].")] = 0.0,
    current: Current = "0m/s",
    level: Level = 0.0,
    output: TrackOutput = None,
    plot: Plot = None,
    json: AsJson = False,
) -> None:
    """Simulate one voyage: where, when and on which side the ship grounds.

    MODEL is a model file, or the name of a published model.
    """
    from math import radians

    from narrows.cli.ranges import speed as read_speed
    from narrows.model.model_file import model_named
    from narrows.simulation.usual import usual_voyage
    from narrows.simulation.voyage import simulate as run

    chosen = model_named(model)
    usual = usual_voyage(chosen, None if speed is None else read_speed("--speed", speed))
    u = usual.speed if speed is None else read_speed("--speed", speed)
    course = _waterway(waterway, read_speed("--current", current), level)
    choices: dict[str, Any] = {"surge": surge, "contact": contact}
    voyage = run(
        chosen, y, u, usual.duration if duration is None else duration, usual.dt if dt is None else dt,
        x=x, psi=radians(psi_deg), v=read_speed("--v", v), r=radians(r_deg),
        X=surge_force, Y=sway_force, N=yaw_moment, rudder=radians(rudder_deg),
        surge_inertia=surge_inertia, coriolis=coriolis, waterway=course, **choices,
        controller=_helm(chosen, controller, hold, u, x, course),
    )  # fmt: skip
    if output:
        voyage.save(output)
    if plot:
        from narrows.files import save_figure
        from narrows.report.voyage_figures import voyage_figure

        save_figure(voyage_figure(voyage), plot)
    if json:
        print_json(voyage.outcome.to_dict())
    else:
        typer.echo(voyage.outcome.sentence)
    say_written((output, plot), json)
    raise SystemExit(int(voyage.outcome.kind == "diverged"))


def _helm(model: "Model", name: str | None, hold: float | None, u: float, x: float, way: "Waterway | None") -> Any:
    """A helm for the model's own canal, or for the section of a waterway where the ship starts."""
    from narrows.control.regulator import regulator
    from narrows.control.track_pilot import track_pilot
    from narrows.errors import check_choice

    if name is not None:
        check_choice("--controller", name, HELMS)
    if hold is None:
        if name is not None:
            raise InputError("--controller needs the offset that it holds: add --hold, or leave it out")
        return None
    if name in (None, "regulator"):
        return regulator(model, hold, u, waterway=way, at=0.0 if way is None else x)
    if name == "predictive":
        from narrows.control.predictive import PredictiveHelm

        return PredictiveHelm(model, hold, u, way)
    if way is None:
        return track_pilot(model, hold, u)
    from dataclasses import replace

    canal = way.canal(x)
    canal = canal if canal.depth else replace(canal, depth=model.configuration.canal.depth)
    there = replace(model, configuration=replace(model.configuration, canal=canal))
    # That section counts from its middle, the voyage from the line.
    return replace(track_pilot(there, hold - float(way.section(x).middle), u), y=hold)


def _waterway(file: Path | None, current: float, level: float) -> "Waterway | None":
    if file is None:
        if current or level:
            raise InputError("--current and --level are a waterway's; add --waterway, or leave them out")
        return None
    from narrows.waterway import read_waterway

    return read_waterway(file).with_water(current, level)


@app.command("map", epilog="Example: narrows map mikkelsen2025_dtc --y -2.5:2.5:101 --speed 0.6:1.2:61 --plot map.png")
def map_(
    model: ModelFile,
    y: Annotated[
        str | None,
        typer.Option(help="Start to starboard [m]: a number, a,b,c or from:to:count; bank to bank unless given."),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            help="Surge velocity: 8kn, 4kn:8kn:5, 1.2m/s; m/s without a unit; what suits the ship unless given."
        ),
    ] = None,
    psi_deg: Annotated[str, typer.Option(help="Heading at the start [deg], likewise.")] = "0",
    width: Annotated[str | None, typer.Option(help="Canal width [m], likewise; the model's own unless given.")] = None,
    samples: Annotated[int, typer.Option(help="Of the coefficients from the fit's covariance.")] = 0,
    within: Annotated[
        float | None, typer.Option(help="With --samples: map the probability of grounding so near [m].")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the samples.")] = 0,
    duration: Duration = None,
    dt: TimeStep = None,
    contact: ContactKind = "corners",
    waterway: WaterwayFile = None,
    x: Annotated[str, typer.Option(help="Start along the waterway [m], likewise.")] = "0",
    current: Current = "0m/s",
    level: Level = 0.0,
    output: DatasetOutput = None,
    plot: Plot = None,
    json: AsJson = False,
) -> None:
    """Map where the ship grounds over one or two things that vary, or how likely it does.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.cli.ranges import speed as read_speed
    from narrows.model.model_file import model_named
    from narrows.results import save_dataset
    from narrows.simulation.ensemble import ensemble
    from narrows.simulation.maps import map_summary

    if within is not None and not 0 < within < float("inf"):
        raise InputError(f"--within {within} is no distance; give metres")
    if within is not None and not samples:
        raise InputError("--within maps a probability, which needs samples of the coefficients: add --samples 200")
    chosen, course = model_named(model), _waterway(waterway, read_speed("--current", current), level)
    shown = sys.stderr.isatty() and not json
    varied, usual = _varied(chosen, y, speed, psi_deg, width, x)
    choices: dict[str, Any] = {"contact": contact}
    voyages = ensemble(
        chosen, duration=usual.duration if duration is None else duration, dt=usual.dt if dt is None else dt,
        samples=samples, seed=seed, progress=shown, waterway=course, **choices, **varied,
    )  # fmt: skip
    if output:
        save_dataset(voyages, output)
    if plot:
        from narrows.files import save_figure
        from narrows.report.map_figures import map_figure

        save_figure(map_figure(voyages, chosen, within, course, varied), plot)
    summary = map_summary(voyages)
    print_json(summary) if json else typer.echo(summary["summary"])
    say_written((output, plot), json)
    raise SystemExit(int(summary["outcomes"]["diverged"] == summary["voyages"]))


def _varied(
    model: "Model", y: str | None, speed: str | None, psi_deg: str, width: str | None, x: str
) -> "tuple[dict[str, Any], UsualVoyage]":
    """What a map varies, by the names of ``ensemble``, a number alone being no dimension; and what else suits it."""
    from math import radians

    import numpy as np

    from narrows.cli.ranges import numbers, speeds
    from narrows.simulation.usual import usual_voyage

    u = None if speed is None else speeds("--speed", speed)
    usual = usual_voyage(model, None if u is None else float(np.abs(u).min()))
    aside = np.linspace(-usual.offset, usual.offset, OFFSETS)
    vary = {
        "y": aside if y is None else numbers("--y", y), "u": np.array([usual.speed]) if u is None else u,
        "psi": radians(1) * numbers("--psi-deg", psi_deg), "x": numbers("--x", x),
    }  # fmt: skip
    if width is not None:
        vary["width"] = numbers("--width", width)
    return {name: values if values.size > 1 else float(values[0]) for name, values in vary.items()}, usual
