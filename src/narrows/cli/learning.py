"""``learn``: improve a model from the ship's own records."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import narrows as nw
from narrows.base.errors import InputError
from narrows.base.progress import LARGE_FILE
from narrows.cli import options as cli
from narrows.empirical.fleet import model_named

# Parts of the JSON output; null if not requested.
PARTS = ("log", "steady", "plan", "information")


LOGS = "The ship's own logs: CSV, Parquet, NMEA 0183."
OWN_SIZE = "Model file at the ship's own size, with a rudder and the covariance of its fit."


@dataclass(frozen=True)
class LogOptions:
    free: Annotated[cli.Words, "Free coefficients: b_bank,c_bank; default: all."] = ""
    sensors: Annotated[str, "Measurement quality of a log: rtk, vdr, ais, or basin."] = "vdr"
    spread: Annotated[float | None, "Relative standard deviation of coefficients without a fit."] = None
    mapping: Annotated[Path | None, "TOML of the log's names, units, signs and delays; see docs/ship-log.md."] = None
    unchecked: Annotated[bool, "Fit although the log's signs, units or clock look wrong."] = False


PILOT_PAGE = cli.Option(help="Plan steady legs and write the pilot's page: .html.", check=cli.named(cli.PAGES))


@dataclass(frozen=True)
class LegOptions:
    steady: Annotated[Path | None, "Steady legs: a table of y, u, rudder and drift, a row per leg."] = None
    plan_steady: Annotated[Path | None, PILOT_PAGE] = None
    legs: Annotated[int, "Number of legs to plan, even."] = 4
    y: Annotated[cli.Numbers | None, "Allowed offsets [m] to either side: a,b,c or from:to:count."] = None
    wind: Annotated[cli.Speed, "Standard deviation of beam wind: 8m/s, 16kn."] = "8m/s"


@cli.verb(
    "narrows learn full.toml bridge.csv --waterway canal.geojson -o learned.toml --report learned.html",
    needs={"waterway": "logs predict_information", "output report": "logs steady"},
    one=("logs steady plan_steady predict_information",),
)
def learn(
    logged: LogOptions,
    legs: LegOptions,
    delivery: cli.ModelDelivery,
    model: Annotated[str, cli.Argument(help=OWN_SIZE)],
    predict_information: Annotated[str | None, "Predict errors of bank coefficients; sensors: rtk or vdr."] = None,
    waterway: cli.WaterwayFile = None,
    speed: Annotated[str | None, "Allowed speeds, or that of transits: 8kn, 4.1m/s."] = None,
    logs: Annotated[list[Path] | None, cli.Argument(help=LOGS, metavar="[LOG]...")] = None,
) -> None:
    """Learn coefficients from a ship's log or steady legs.

    Steady legs are held to one side of the canal and then to the other.
    """
    ship = model_named(model)
    if logs:
        found = _learn(ship, logs, logged, waterway, delivery)
    elif legs.steady is not None:
        found = _learn_steady(ship, legs, legs.steady, delivery)
    elif legs.plan_steady is not None:
        found = _plan(ship, legs, legs.plan_steady, speed, delivery.json)
    else:
        found = _predict_information(ship, predict_information or "", waterway, speed, delivery.json)
    raise SystemExit(int(not found))


def _learn(
    model: "nw.Model", logs: list[Path], logged: LogOptions, waterway: Path | None, delivery: cli.ModelDelivery
) -> bool:
    from narrows.report.learning_pages import print_learned, write_log_report

    twice = next((log for place, log in enumerate(logs) if log in logs[:place]), None)
    if twice is not None:
        raise InputError(f"{twice} is given twice and would count twice; give each log once")
    way = None if waterway is None else nw.read_waterway(waterway)
    # Logs in memory, or read from disk at each pass if one is large.
    large = len(logs) == 1 and logs[0].is_file() and logs[0].stat().st_size >= LARGE_FILE
    log: Any = nw.stream_log(logs[0], way, logged.mapping) if large else nw.read_log(logs, way, logged.mapping)
    doubts: tuple[str, ...] = ()
    if not logged.unchecked:
        findings = nw.check_log(log, model, sensors=logged.sensors, spread=logged.spread)
        if wrong := findings.wrong:
            more = f" ({len(wrong) - 1} more: see nw.check_log)" if len(wrong) > 1 else ""
            raise InputError(f"{wrong[0].record}: {wrong[0].sentence}; {wrong[0].remedy}{more}, or give --unchecked")
        doubts = findings.doubts
    fit = nw.learn(model, log, free=logged.free, sensors=logged.sensors, spread=logged.spread)
    fit = replace(fit, about=(*doubts, *fit.about))
    delivery.give(
        fit, lambda fit: print_learned(fit, "estimate from the log"), save=fit.model.save,
        report=lambda path: write_log_report(fit, path), values=lambda: _told(fit, log=fit.to_dict()),
    )  # fmt: skip
    return fit.informative


def _learn_steady(model: "nw.Model", legs: LegOptions, table: Path, delivery: cli.ModelDelivery) -> bool:
    from narrows.report.learning_pages import print_learned, write_steady_report

    fit = nw.learn_steady(model, table, conditions=nw.SteadyConditions(wind=legs.wind))
    delivery.give(
        fit, lambda fit: print_learned(fit, "information"), save=fit.model.save,
        report=lambda path: write_steady_report(fit, path), values=lambda: _told(fit, steady=fit.to_dict()),
    )  # fmt: skip
    return fit.informative


def _plan(model: "nw.Model", legs: LegOptions, page: Path, speed: str | None, json: bool) -> bool:
    from narrows.report.learning_pages import print_steady_plan, write_pilot_page

    ahead = None if speed is None else cli.speeds("--speed", speed)
    plan = nw.plan_steady(model, legs.y, ahead, legs=legs.legs, conditions=nw.SteadyConditions(wind=legs.wind))
    shown = cli.Delivery(page if plan.legs else None, json)
    values = _told(plan, plan=plan.to_dict())
    shown.give(plan, print_steady_plan, save=lambda path: write_pilot_page(plan, path), values=lambda: values)
    return bool(plan.legs)


def _predict_information(model: "nw.Model", sensors: str, waterway: Path | None, speed: str | None, json: bool) -> bool:
    from narrows.report.learning_pages import print_information

    way = None if waterway is None else nw.read_waterway(waterway)
    u = None if speed is None else cli.speed("--speed", speed)
    found = nw.predict_information(model, way, sensors, u=u)
    values = _told(found, information=found.to_dict())
    cli.Delivery(json=json).give(found, print_information, values=lambda: values)
    return True


def _told(result: "nw.LogFit | nw.SteadyFit | nw.SteadyPlan | nw.InformationForecast", **parts: Any) -> dict[str, Any]:
    return {"summary": result.summary(), **dict.fromkeys(PARTS), **parts, "notes": list(result.notes)}
