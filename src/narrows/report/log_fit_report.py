"""What a log taught, as one self-contained page."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from narrows.files import write_whole
from narrows.logbook import LogFit
from narrows.logbook.learning.record_answers import RecordAnswer
from narrows.logbook.standing import ON_TWINS
from narrows.report.fit_page import figure, render
from narrows.report.learned_table import learned_rows, with_truth
from narrows.report.log_fit_figures import forecast_figure, log_fit_figure
from narrows.report.log_track_figure import log_track_figure

# What forecasts miss: state, words, factor.
MISSED = (("y", "offset [m]", 1.0), ("psi", "heading [deg]", 180 / np.pi), ("r", "yaw rate [deg/s]", 180 / np.pi))
BESIDE = "Measured, and foretold every 3.5 ship lengths under the recorded rudder."


def write_log_report(fit: LogFit, path: str | Path, truth: Mapping[str, float] | None = None) -> None:
    """Write one HTML file with what a log taught, each record beside its forecasts."""
    caption = (
        "Left: coefficients after the log, in standard deviations before it, with 95 % intervals. Right: what "
        "forecasts over 3.5 ship lengths miss of each record, by the model before and by one that learned from all "
        "other records."
    )
    page = render(
        "log_fit.html.j2",
        title=f"{fit.prior.configuration.ship.name or 'A ship'}: what its own log taught",
        said=fit.summary().splitlines(),
        learned=with_truth(learned_rows(fit.coefficients), truth),
        twin=truth is not None,
        figure=figure(log_fit_figure(fit), caption),
        missed_heads=[words for _, words, _ in MISSED],
        records=[_row(fit, number) for number in range(len(fit.records))],
        informed=list(_informed(fit)),
        forecasts=[picture for record in fit.records if record.forecasts for picture in _pictures(record)],
        notes=[note for note in fit.notes if note != ON_TWINS],
    )
    write_whole(path, page)


def _pictures(record: RecordAnswer) -> Iterator[dict[str, str]]:
    """A record with its forecasts: from above where its places are known, and over time."""
    if {"x", "y"} <= set(record.measured):
        yield figure(log_track_figure(record), f"From above. {BESIDE}")
    yield figure(forecast_figure(record), BESIDE)


def _informed(fit: LogFit) -> tuple[str, ...]:
    """Coefficients whose records are compared: those of the bank, or those that were learned best."""
    known = [c for c in fit.coefficients.values() if c.name in fit.records[0].information]
    bank = [c.name for c in known if c.from_bank]
    return tuple(bank or [c.name for c in sorted(known, key=lambda c: c.left)[:3]])


def _row(fit: LogFit, number: int) -> dict[str, object]:
    record = fit.records[number]
    return {
        "name": record.name,
        "minutes": f"{record.duration / 60:.3g}",
        "missed": [f"{factor * old:.2g} to {factor * new:.2g}" for name, _, factor in MISSED
                   for old, new in (record.missed[name],)],
        "information": [f"{100 * record.information[name]:.0f} %" for name in _informed(fit)],
    }  # fmt: skip
