"""``simulate`` and ``map``: where, when and on which side a ship grounds."""

import sys
from typing import Any

import typer

import narrows
from narrows.cli.delivery import DatasetDelivery, TrackDelivery
from narrows.cli.grouped import verb
from narrows.cli.options import ModelFile
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

    from narrows.model.model_file import model_named
    from narrows.simulation.usual import usual_voyage
    from narrows.simulation.voyage import simulate as run

    chosen, waterway = model_named(model), water.read()
    usual = usual_voyage(chosen, start.u)
    u = usual.speed if start.u is None else start.u
    options: dict[str, Any] = start.values() | push.values() | time.values(usual) | vars(physics)
    controller = helm.of(chosen, u, start.x, waterway)
    voyage = run(chosen, u=u, rudder=radians(helm.rudder_deg), waterway=waterway, controller=controller, **options)
    delivery.write(voyage.save, voyage.plot)
    delivery.tell(voyage.to_dict, lambda: typer.echo(voyage.summary()))
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
    from narrows.model.model_file import model_named
    from narrows.results import save_dataset
    from narrows.simulation.ensemble import ensemble
    from narrows.simulation.maps import map_summary
    from narrows.simulation.usual import usual_voyage

    chosen, waterway = model_named(model), water.read()
    usual = usual_voyage(chosen, None if varied.u is None else float(abs(varied.u).min()))
    vary, choices = varied.values(usual, OFFSETS), dict[str, Any](contact=contact)
    voyages = ensemble(
        chosen, samples=samples.samples, seed=samples.seed, waterway=waterway,
        progress=sys.stderr.isatty() and not delivery.json, **time.values(usual), **choices, **vary,
    )  # fmt: skip
    delivery.write(
        lambda path: save_dataset(voyages, path),
        lambda: narrows.report.map_figure(voyages, chosen, samples.within, waterway, vary),
    )
    summary = map_summary(voyages)
    delivery.tell(lambda: summary, lambda: typer.echo(summary["summary"]))
    raise SystemExit(int(summary["outcomes"]["diverged"] == summary["voyages"]))
