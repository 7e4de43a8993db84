"""The table of transits: rows of the script, intervals that cover, and what the script computes."""

import csv
import importlib
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def script():
    sys.path.insert(0, str(ROOT / "decisions"))
    for name in ("transits", "pages"):
        sys.modules.pop(name, None)
    yield importlib.import_module("transits")
    sys.path.remove(str(ROOT / "decisions"))


def table() -> dict[str, list[str]]:
    """The cells of each row, by what sails."""
    with (ROOT / "decisions" / "transits.csv").open(encoding="utf-8", newline="") as file:
        return {row[0]: row for row in list(csv.reader(file))[1:]}


def share(cell: str) -> float:
    return float(cell.rstrip("%")) / 100


def test_every_row_is_one_of_the_script(script) -> None:
    assert {"vdr, 1 transit", "vdr, 5 transits"} <= table().keys() <= {kind.words for kind in script.KINDS}


def known(twins: str) -> float:
    """Two standard errors of a share of 95 %."""
    return 2 * (0.95 * 0.05 / int(twins)) ** 0.5


def clean() -> list[list[str]]:
    """Rows of twins that differ from the fit's assumptions in nothing: they have a forecast."""
    return [row for row in table().values() if row[5] != "-"]


def test_intervals_cover_as_far_as_so_many_twins_tell() -> None:
    """Within two standard errors of 95 % by the number of twins."""
    assert len(clean()) >= 6
    for row in clean():
        for cell in (row[2], row[6]):
            assert share(cell) >= 0.95 - known(row[1]) - 0.01, row


# Of several transits by AIS more searches end without rest, and each says so.
RESTLESS = "ais and the rudder, 5 transits"


def test_most_fits_come_to_rest() -> None:
    for row in clean():
        assert (share(row[12].partition(",")[0]) <= 0.1) == (row[0] != RESTLESS), row


@pytest.mark.slow
def test_a_twin_is_one_of_those_of_the_table(script) -> None:
    """A row of one twin: found within four of its standard errors, which are about those of the table."""
    kind = next(kind for kind in script.KINDS if kind.words == "vdr, 1 transit")
    told = next(script.kept_figures(kind, 1, None))
    for name, cell in zip(script.BANKS, (table()[kind.words][4], table()[kind.words][8]), strict=True):
        assert abs(told["off"][name]) < 4
        assert 0.2 < told["std"][name] / float(cell) < 5
