"""The table of twins that break assumptions: complete, within its limits, and what its script computes."""

import csv
import importlib
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(ROOT / "decisions")
    for name in ("trust_twins", "trust_kinds", "trust_tank", "pages"):
        sys.modules.pop(name, None)
    return importlib.import_module("trust_twins")


def rows() -> list[list[str]]:
    """Return the cells of the whole table."""
    with (ROOT / "decisions" / "trust_twins.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))[1:]


def share(cell: str) -> float:
    return float(cell.rstrip("%")) / 100


def test_every_kind_has_its_strengths(script) -> None:
    expected = [(kind.__name__, f"{s:g}") for kind, strengths in script.KINDS.items() for s in strengths]
    assert [(row[0].split("`")[1], row[1]) for row in rows()] == expected
    assert len(script.KINDS) >= 20


def test_the_page_has_the_rows_that_mislead(script) -> None:
    page = (ROOT / "docs" / "uncertainty.md").read_text(encoding="utf-8")
    table = page.partition("<!-- made by decisions/trust_twins.py -->\n")[2].partition("\n<!-- end -->")[0]
    assert table == script.text(script.kept())
    assert 0 < len(script.misled(script.kept())) < len(rows()) / 3


def test_no_kind_misleads_in_more_than_one_twin_of_ten_but_those_that_the_page_names() -> None:
    page = (ROOT / "docs" / "uncertainty.md").read_text(encoding="utf-8")
    named = page.partition("**Errors that no data reveal**")[2].partition("\n\n")[0]
    assert sum(share(row[2]) for row in rows() if f"`{row[0].split('`')[1]}`" not in named) / len(rows()) < 0.02
    for row in rows():
        assert share(row[2]) <= 0.1 or f"`{row[0].split('`')[1]}`" in named, row


def test_a_plan_that_separates_has_its_power() -> None:
    for row in rows():
        if row[0].startswith("`honest`"):
            assert min(share(row[3]), share(row[4])) >= 0.9


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "number"), [("hull_by_speed", 1), ("honest", 1), ("near_repeats", 0)])
def test_the_table_is_what_is_computed(script, kind: str, number: int) -> None:
    own = next(own for own in script.KINDS if own.__name__ == kind)
    kept = [row for row in rows() if row[0].startswith(f"`{kind}`")][number]
    made = list(script.row(own, script.KINDS[own][number]))
    assert kept[:2] == made[:2]
    assert [share(cell) for cell in kept[2:7]] == pytest.approx([share(cell) for cell in made[2:7]], abs=0.021)
