"""``simulate`` and ``map``: where, when and on which side a ship grounds."""

import sys
from typing import Annotated, Any

import click

import narrows
from narrows.cli.declarations import Option
from narrows.cli.options import AsJson, DatasetDelivery, ModelFile, Plot, TableOutput, TrackDelivery, verb
from narrows.cli.output import print_json, say_written
from narrows.cli.voyage_options import (
    ContactKind,
    HelmOptions,
    PhysicsOptions,
    PushOptions,
    SampleOptions,
    StartOptions,
    TimeOptions,
    VariedOptions,
    WaterOptions,
)

# Of a map, where none are given.
OFFSETS = 101


@verb("narrows simulate mikkelsen2025_dtc --y 0.5 --speed 1m/s -o voyage.nc --plot voyage.png")
def simulate(
    model: ModelFile,
    start: StartOptions,
    push: PushOptions,
    helm: HelmOptions,
    time: TimeOptions,
    physics: PhysicsOptions,
    water: WaterOptions,
    delivery: TrackDelivery,
) -> None:
    """Simulate one voyage: where, when and on which side the ship grounds.

    MODEL is a model file, or the name of a published model.
    """
    from math import radians

    from narrows.empirical.fleet import model_named
    from narrows.simulation.departure import voyage_defaults
    from narrows.simulation.voyage import simulate as run

    chosen, waterway = model_named(model), water.read()
    u = voyage_defaults(chosen).speed if start.u is None else start.u
    options: dict[str, Any] = start.values() | push.values() | vars(time) | vars(physics)
    controller = helm.of(chosen, u, start.x, waterway)
    voyage = run(chosen, u=u, rudder=radians(helm.rudder_deg), waterway=waterway, controller=controller, **options)
    delivery.write(voyage.save, voyage.plot)
    delivery.tell(voyage.to_dict, lambda: click.echo(voyage.summary()))
    raise SystemExit(int(voyage.outcome.kind == "diverged"))


@verb("narrows map mikkelsen2025_dtc --y -2.5:2.5:101 --speed 0.6:1.2:61 --plot map.png", name="map")
def map_(
    model: ModelFile,
    varied: VariedOptions,
    samples: SampleOptions,
    time: TimeOptions,
    water: WaterOptions,
    delivery: DatasetDelivery,
    contact: ContactKind = "corners",
) -> None:
    """Map where the ship grounds over one or two things that vary, or how likely it does.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.empirical.fleet import model_named
    from narrows.results import save_dataset
    from narrows.simulation.departure import voyage_defaults
    from narrows.simulation.ensemble import ensemble
    from narrows.simulation.maps import map_summary

    chosen, waterway = model_named(model), water.read()
    usual = voyage_defaults(chosen, varied.u)
    vary, choices = varied.values(usual, OFFSETS), dict[str, Any](contact=contact)
    voyages = ensemble(
        chosen, samples=samples.samples, seed=samples.seed, waterway=waterway,
        progress=sys.stderr.isatty() and not delivery.json, **vars(time), **choices, **vary,
    )  # fmt: skip
    delivery.write(
        lambda path: save_dataset(voyages, path),
        lambda: narrows.report.map_figure(voyages, chosen, samples.within, waterway, vary),
    )
    summary = map_summary(voyages)
    delivery.tell(lambda: summary, lambda: click.echo(summary["summary"]))
    raise SystemExit(int(summary["outcomes"]["diverged"] == summary["voyages"]))


@verb("narrows trials yasukawa2015_kvlcc2 --speed 1.179m/s --plot tracks.png")
def trials(
    model: ModelFile,
    speed: Annotated[str, Option(help="Of the approach: 1.2m/s, 8kn; m/s without a unit.")],
    turn_deg: Annotated[float, Option(help="Rudder of the turning circles, to either side [deg].")] = 35.0,
    zigzags: Annotated[str, Option(help="Rudder/heading of the zigzags [deg], a/b,c/d.")] = "10/10,20/20",
    dt: Annotated[float | None, Option(help="Time step [s]; a 120th of the time for a ship length.")] = None,
    output: TableOutput = None,
    plot: Plot = None,
    json: AsJson = False,
) -> None:
    """Turn circles and sail zigzags in open water: advance, tactical diameter, overshoots.

    MODEL is a model file with the terms of a rudder, or the name of a published model. Terms of the banks are left out.
    """
    from narrows.cli.options import speed as read_speed
    from narrows.empirical.fleet import model_named
    from narrows.manoeuvres.manoeuvring_trials import parse_zigzags, sail_trials
    from narrows.report.manoeuvre_report import manoeuvres_figure, print_manoeuvres

    result = sail_trials(model_named(model), read_speed("--speed", speed), turn_deg, parse_zigzags(zigzags), dt)
    if output:
        result.save(output)
    if plot:
        from narrows.files import save_figure

        save_figure(manoeuvres_figure(result), plot)
    print_json(result.to_dict()) if json else print_manoeuvres(result)
    say_written((output, plot), json)
