"""The report: self-contained, complete, legible."""

import re
from html import unescape
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from rich.console import Console

import narrows as nw
from narrows.report.fit_figures import (
    correlation_figure,
    delta_figure,
    delta_surface_figure,
    forces_figure,
    intervals_figure,
    motions_figure,
)
from narrows.report.fit_page import write_report
from narrows.report.printed_tables import print_fit
from tables import DTC_SHIP, frame_of, written

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def page(kcs_fits: dict[int, nw.Fit], short: nw.CaptiveTests, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Of a fit with rows, and of one that was streamed."""
    folder = tmp_path_factory.mktemp("report")
    (folder / "ship.toml").write_text(DTC_SHIP)
    streamed = nw.identify(nw.stream_captive(written(frame_of(short), folder / "t.csv"), folder / "ship.toml"))
    write_report({"50": kcs_fits[50], "twin": streamed}, folder / "report.html", "KCS")
    return (folder / "report.html").read_text()


def test_page_needs_nothing_else(page: str) -> None:
    assert not re.findall(r"(?:src|href)=\"(?!#)", page.replace("xlink:href", "").replace('href="#', ""))
    assert "<script" not in page
    assert page.count("<figure") == 5 + 2
    assert len(page) < 4_000_000


def test_the_answer_stands_below_the_first_figure_and_above_the_table(page: str) -> None:
    assert page.index("<figure") < page.index("The tests do not determine the bank") < page.index(">verdict</th>")


def test_page_says_everything(page: str, kcs_fits: dict[int, nw.Fit]) -> None:
    text = unescape(re.sub(r"<[^>]+>", "", page.replace("</summary>", ": ")))  # A sentence opens at its colon.
    for name, verdict in kcs_fits[50].verdicts.items():
        assert f"<th>{name}</th>" in page
        if verdict.status != "identified":
            assert verdict.sentence(name) in text
    assert kcs_fits[50].tests.source.sha256 in page
    assert kcs_fits[50].motions.sentence in page


def figures(fit: nw.Fit) -> list[Figure]:
    tests, configuration = fit.tests, fit.tests.configuration
    return [
        motions_figure(tests), forces_figure(fit, tests), intervals_figure(fit),
        correlation_figure(fit),
        delta_figure(configuration, (0.0, 0.9)), delta_surface_figure(configuration),
    ]  # fmt: skip


@pytest.mark.parametrize("source", ["twin", "kcs"])
def test_axes_carry_units(source: str, twin_fit: nw.Fit, kcs_fits: dict[int, nw.Fit]) -> None:
    for figure in figures(twin_fit if source == "twin" else kcs_fits[20]):
        labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]
        assert len(labels) >= 1
        assert all("[" in text for text in labels), labels


def test_terminal_fits_eighty_columns(kcs_fits: dict[int, nw.Fit]) -> None:
    console = Console(width=80, record=True, highlight=False, file=open("/dev/null", "w"))  # noqa: SIM115
    with console.file:
        print_fit(kcs_fits[50], "deep", console)
        shown = console.export_text()
    assert max(map(len, shown.splitlines())) <= 80
    rows = [line for line in shown.splitlines() if line.startswith("b_vdot ")]
    assert f"{kcs_fits[50].coefficients['b_vdot']:.0f}" in rows[0]
    assert kcs_fits[50].verdicts["b_vdot"].status in rows[0]


def test_a_streamed_fit_has_a_report_without_rows(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path) -> None:
    fit = nw.identify(nw.stream_captive(written(frame_of(short), tmp_path / "t.csv"), ship_file))
    write_report({"": fit}, tmp_path / "r.html")
    assert (tmp_path / "r.html").read_text().count("<figure") == 2
