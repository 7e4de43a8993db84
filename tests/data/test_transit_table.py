"""The table of transits: complete, within what the page promises, foreseen beforehand, and what the script computes."""

import importlib
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
IN_DOUBT = {"a ship passes every ten minutes"}
"""Of which every answer says that it is."""
LESS_COVERED = {"draft a tenth less, and not said", "a ship passes every ten minutes, marked in the log"}
"""Of which the page says that intervals hold somewhat less often than they say."""
HOPEFUL = 2.35
"""By how much at most less is foreseen than fits find, as the page says."""


@pytest.fixture(scope="module")
def script():
    sys.path.insert(0, str(ROOT / "decisions"))
    for name in ("transits", "pages"):
        sys.modules.pop(name, None)
    yield importlib.import_module("transits")
    sys.path.remove(str(ROOT / "decisions"))


def table() -> dict[str, list[str]]:
    """The cells of each row, by what sails."""
    page = (ROOT / "docs" / "learning.md").read_text(encoding="utf-8")
    kept = page.partition("<!-- made by decisions/transits.py -->\n")[2].partition("\n<!-- end -->")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in kept.splitlines()[2:]]
    return {row[0]: row for row in rows}


def share(cell: str) -> float:
    return float(cell.rstrip("%")) / 100


def test_every_kind_has_its_row(script) -> None:
    assert list(table()) == [kind.words for kind in script.KINDS]
    assert [int(row[1]) for row in table().values()] == [kind.twins for kind in script.KINDS]


def known(twins: str) -> float:
    """Two standard errors of a share of 95 %."""
    return 2 * (0.95 * 0.05 / int(twins)) ** 0.5


def test_intervals_cover_as_far_as_so_many_twins_tell() -> None:
    """Within two standard errors of 95 % by the number of twins, or of 85 % where the page says so."""
    for row in table().values():
        least = (0.85 if row[0] in LESS_COVERED else 0.95) - known(row[1])
        for cell in (row[2], row[6]):
            assert cell == "-" or share(cell) >= least - 0.01, row


def test_a_bank_that_is_not_there_is_called_unresolved() -> None:
    row = table()["no bank in the moment"]
    assert share(row[10]) >= 0.95 - known(row[1]) - 0.01


def test_ships_that_pass_unmarked_are_said_in_every_answer() -> None:
    assert all(share(table()[words][11]) == 1.0 for words in IN_DOUBT)


def test_most_fits_come_to_rest() -> None:
    """Of one transit all but a few; of more by coarse sensors fewer, as the page says."""
    for words, row in table().items():
        assert share(row[12].partition(",")[0]) <= (0.1 if " 20 " not in words and " 5 " not in words else 0.35), row


def test_what_is_foreseen_is_what_fits_find() -> None:
    """Standard errors beside the median of those of fits."""
    for row in table().values():
        for found, ahead in ((row[4], row[5]), (row[8], row[9])):
            assert ahead == "-" or 0.6 < float(found) / float(ahead) < HOPEFUL, row


@pytest.mark.slow
def test_a_twin_is_one_of_those_of_the_table(script) -> None:
    """A row of one twin: found within four of its standard errors, which are about those of the table."""
    kind = next(kind for kind in script.KINDS if kind.words == "vdr, 1 transit")
    told = next(script.kept_figures(kind, 1, None))
    for name, cell in zip(script.BANKS, (table()[kind.words][4], table()[kind.words][8]), strict=True):
        assert abs(told["off"][name]) < 4
        assert 0.2 < told["std"][name] / float(cell) < 5
