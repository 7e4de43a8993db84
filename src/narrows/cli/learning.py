"""``learn``: a model that knows more, from what the ship itself did."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, ModelFile, ModelOutput, Report, WaterwayFile
from narrows.cli.output import named, print_json, say_written
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.logbook import EnvelopeChange, Foresight, SteadyFit, SteadyPlan
    from narrows.model.model import Model

PARTS = ("steady", "envelope", "plan", "foresight")
"""Of what is printed as JSON; null where it was not asked for."""
PILOT_PAGES = (".html", ".pdf", ".svg", ".png")


@app.command(epilog="Example: narrows learn full.toml --steady held.csv -o learned.toml --report learned.html")
def learn(
    model: ModelFile,
    steady: Annotated[
        Path | None,
        typer.Option(help="Steady legs off the middle: a table of y, u, rudder and drift or heading, a row a leg."),
    ] = None,
    plan_steady: Annotated[
        Path | None,
        typer.Option(
            help="Plan steady legs and write the pilot's page: .html, .pdf, .svg or .png.", callback=named(PILOT_PAGES)
        ),
    ] = None,
    foresee: Annotated[
        str | None, typer.Option(help="Say how tight the bank's coefficients will get by transits, sensors rtk or vdr.")
    ] = None,
    waterway: WaterwayFile = None,
    legs: Annotated[int, typer.Option(help="How many legs to plan, an even number.")] = 4,
    y: Annotated[
        str | None, typer.Option(help="Offsets [m] that may be held, to either side: a,b,c or from:to:count.")
    ] = None,
    speed: Annotated[str | None, typer.Option(help="Speeds that may be held: 8kn, 6kn:10kn:3, 4.1m/s.")] = None,
    wind: Annotated[str, typer.Option(help="Beam wind of one standard deviation: 8m/s, 16kn.")] = "8m/s",
    output: ModelOutput = None,
    report: Report = None,
    json: AsJson = False,
) -> None:
    """Learn the bank's coefficients from the ship itself: held to one side, then to the other.

    MODEL is a model file at the ship's own size, with the terms of a rudder and the covariance of its fit.
    """
    from narrows.cli.ranges import speed as read_speed
    from narrows.logbook import SteadyConditions
    from narrows.model.model_file import model_named

    if sum(asked is not None for asked in (steady, plan_steady, foresee)) != 1:
        raise InputError(
            "give --steady with legs that were held, --plan-steady to plan some, or --foresee; one of them"
        )
    if waterway is not None and foresee is None:
        raise InputError("--waterway is for --foresee; steady legs are held in the canal of the model")
    ship, conditions = model_named(model), SteadyConditions(wind=read_speed("--wind", wind))
    if steady is None and (output or report):
        raise InputError("nothing is learned yet: leave --output and --report out, or give --steady")
    if foresee is not None:
        told = _foresee(ship, foresee, waterway, speed, json)
    elif plan_steady is not None:
        told = _plan(ship, conditions, plan_steady, legs, y, speed, json)
    else:
        told = _learn_steady(ship, conditions, steady, output, report, json)
    say_written((output, report, plan_steady) if told else (output, report), json)
    raise SystemExit(int(not told))


def _learn_steady(
    model: "Model", conditions: Any, legs: Path | None, output: Path | None, report: Path | None, json: bool
) -> bool:
    """Learn, print, write; return whether the legs tell of the bank."""
    from narrows.logbook import learn_steady
    from narrows.report.steady_report import write_steady_report
    from narrows.report.steady_table import print_steady_fit

    fit = learn_steady(model, legs, conditions=conditions)
    change = _change(fit)
    if output:
        fit.model.save(output)
    if report:
        write_steady_report(fit, change, report)
    if json:
        print_json(_told(fit, steady=fit.to_dict(), envelope=change.to_dict()))
    else:
        print_steady_fit(fit, change)
    return fit.tells


def _change(fit: "SteadyFit") -> "EnvelopeChange":
    from narrows.logbook.envelope_change import envelope_change, places_of
    from narrows.progress import stage

    configuration, read = fit.prior.configuration, fit.readings.values
    room = (configuration.canal.width - configuration.ship.beam) / 2
    with stage("asking the safe envelope of both models"):
        return envelope_change(fit.prior, fit.model, *places_of(read["y"], read["u"], room))


def _plan(
    model: "Model", conditions: Any, page: Path, legs: int, y: str | None, speed: str | None, json: bool
) -> bool:  # fmt: skip
    """Plan, print, write the pilot's page; return whether there is a leg."""
    from narrows.cli.ranges import numbers, speeds
    from narrows.logbook import plan_steady
    from narrows.report.pilot_page import write_pilot_page
    from narrows.report.steady_table import print_steady_plan

    offsets = None if y is None else numbers("--y", y)
    ahead = None if speed is None else speeds("--speed", speed)
    plan = plan_steady(model, offsets, ahead, legs=legs, conditions=conditions)
    if plan.legs:
        write_pilot_page(plan, page)
    print_json(_told(plan, plan=plan.to_dict())) if json else print_steady_plan(plan)
    return bool(plan.legs)


def _foresee(model: "Model", sensors: str, waterway: Path | None, speed: str | None, json: bool) -> bool:
    """Foretell and print; return whether anything is foretold."""
    from narrows.cli.ranges import speed as read_speed
    from narrows.logbook import foresee
    from narrows.report.foresight_view import print_foresight
    from narrows.waterway import read_waterway

    way = None if waterway is None else read_waterway(waterway)
    found = foresee(model, way, sensors, u=None if speed is None else read_speed("--speed", speed))
    print_json(_told(found, foresight=found.to_dict())) if json else print_foresight(found)
    return bool(found.kinds)


def _told(result: "SteadyFit | SteadyPlan | Foresight", **parts: Any) -> dict[str, Any]:
    """What the verb prints as JSON: its summary and notes, and each part that was asked for."""
    return {"summary": result.summary(), **dict.fromkeys(PARTS), **parts, "notes": list(result.notes)}
