"""``learn``: improve a model from the ship's own records."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
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


PILOT_PAGE = cli.Option(help="Plan steady legs and write the pilot's page: .html.", forms=cli.PAGES)


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
    from narrows.report import learning_pages as pages

    ship, way = model_named(model), None if waterway is None else nw.read_waterway(waterway)
    result: Any
    words: Callable[[Any], None]
    report: Callable[[Any, Path], None] = pages.write_steady_report
    if logs:
        result, part, report = _learn(ship, logs, logged, way), "log", pages.write_log_report
        words, found = partial(pages.print_learned, verdict="estimate from the log"), result.informative
    elif legs.steady is not None:
        result = nw.learn_steady(ship, legs.steady, conditions=nw.SteadyConditions(wind=legs.wind))
        part, words, found = "steady", partial(pages.print_learned, verdict="information"), result.informative
    elif legs.plan_steady is not None:
        ahead = None if speed is None else cli.speeds("--speed", speed)
        conditions = nw.SteadyConditions(wind=legs.wind)
        result = nw.plan_steady(ship, legs.y, ahead, legs=legs.legs, conditions=conditions)
        part, words, found = "plan", pages.print_steady_plan, bool(result.legs)
        delivery = cli.Delivery(legs.plan_steady if found else None, delivery.json)
    else:
        u = None if speed is None else cli.speed("--speed", speed)
        result = nw.predict_information(ship, way, predict_information or "", u=u)
        part, words, found = "information", pages.print_information, True
    told = {"summary": result.summary(), **dict.fromkeys(PARTS), part: result.to_dict(), "notes": list(result.notes)}
    delivery.give(
        result, words, report=partial(report, result), values=lambda: told,
        save=partial(pages.write_pilot_page, result) if part == "plan" else lambda path: result.model.save(path),
    )  # fmt: skip
    raise SystemExit(int(not found))


def _learn(model: "nw.Model", logs: list[Path], logged: LogOptions, way: "nw.Waterway | None") -> "nw.LogFit":
    from narrows.logbook.learned_coefficients import with_spread

    twice = next((log for place, log in enumerate(logs) if log in logs[:place]), None)
    if twice is not None:
        raise InputError(f"{twice} is given twice and would count twice; give each log once")
    # Logs in memory, or read from disk at each pass if one is large.
    large = len(logs) == 1 and logs[0].is_file() and logs[0].stat().st_size >= LARGE_FILE
    log: Any = nw.stream_log(logs[0], way, logged.mapping) if large else nw.read_log(logs, way, logged.mapping)
    with_spread(model, logged.spread)  # A model without a prior is refused before its log is checked
    doubts: tuple[str, ...] = ()
    if not logged.unchecked:
        findings = nw.check_log(log, model, sensors=logged.sensors, spread=logged.spread)
        if wrong := findings.wrong:
            more = f" ({len(wrong) - 1} more: see nw.check_log)" if len(wrong) > 1 else ""
            raise InputError(f"{wrong[0].record}: {wrong[0].sentence}; {wrong[0].remedy}{more}, or give --unchecked")
        doubts = findings.doubts
    fit = nw.learn(model, log, free=logged.free, sensors=logged.sensors, spread=logged.spread)
    return replace(fit, about=(*doubts, *fit.about))
