"""The tables of the steady experiment: complete, within what the page promises, and what the script computes."""

import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
NUMBER = re.compile(r"-?\d+\.?\d*")
NOT_COVERED = {"all legs on one side", "wind changes by half of what it is", "wind changes by as much as it is"}
"""Which the page says are not, or less."""


@pytest.fixture(scope="module")
def script():
    sys.path.insert(0, str(ROOT / "decisions"))
    for name in ("steady", "suez", "pages"):
        sys.modules.pop(name, None)
    yield importlib.import_module("steady")
    sys.path.remove(str(ROOT / "decisions"))


@pytest.fixture(scope="module")
def tables(script) -> tuple[list[list[str]], list[list[str]]]:
    """The first table with its head, the second without."""
    rows = importlib.import_module("pages").kept("steady")
    second = next(i for i, row in enumerate(rows) if row[0] == "twins")
    return rows[:second], rows[second + 1 :]


def share(cell: str) -> float:
    return float(cell.rstrip("%")) / 100


def test_every_kind_has_its_row(script, tables) -> None:
    assert [row[0] for row in tables[1]] == [kind.words for kind in script.KINDS]


def test_intervals_cover_where_the_page_says_so(tables) -> None:
    for row in tables[1]:
        if row[0] not in NOT_COVERED:
            covered = [share(cell) for cell in row[3:7] if cell != "-"]
            assert min(covered) >= 0.85, row


def test_a_bank_that_is_not_there_is_called_unresolved(tables) -> None:
    row = next(row for row in tables[1] if row[0] == "no bank at all")
    assert share(row[9]) <= 0.05


@pytest.mark.slow
def test_the_first_table_is_what_is_computed(script, tables) -> None:
    kept, made = (str(rows) for rows in (tables[0], importlib.import_module("pages").cells(script.reported())))
    assert NUMBER.sub("#", kept) == NUMBER.sub("#", made)
    numbers = [np.array([float(n) for n in NUMBER.findall(text)]) for text in (kept, made)]
    np.testing.assert_allclose(numbers[0], numbers[1], rtol=0.05, atol=0.11)


@pytest.mark.slow
@pytest.mark.parametrize("words", ["default assumptions", "wind changes by as much as it is"])
def test_a_row_is_what_a_few_of_its_twins_say(script, tables, words: str) -> None:
    """Within four standard errors of so few."""
    kept = next(row for row in tables[1] if row[0] == words)
    made = script.row(next(kind for kind in script.KINDS if kind.words == words), 12)
    held = int(made[1].split()[0])
    for before, now in zip(kept[2:7], made[2:7], strict=True):
        chance = min(max(share(before), 0.02), 0.98)
        assert abs(share(now) - chance) <= 4 * np.sqrt(chance * (1 - chance) / held)
