"""Puts what a script of this folder computes between its two marks on a page of the docs."""

import csv
import sys
from collections.abc import Callable
from itertools import takewhile
from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"
END = "<!-- end -->"
Rows = list[list[str]]


def publish(script: str, page: str, made: str, shown: Callable[[Rows], str] | None = None) -> None:
    """Print what was computed; with --write put it on its page too.

    Where the page shows a part, `shown` makes it of all rows, which are then kept in a CSV beside the script.
    """
    print(made)
    if "--write" not in sys.argv:
        return
    if shown:
        with Path(script).with_suffix(".csv").open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(cells(made))
        made = shown(cells(made))
    path, start = DOCS / page, f"<!-- made by decisions/{Path(script).name} -->"
    before, mark, rest = path.read_text(encoding="utf-8").partition(start)
    if not mark:
        raise SystemExit(f"{path} has no mark {start}")
    path.write_text(f"{before}{start}\n{made}\n{END}{rest.partition(END)[2]}", encoding="utf-8")


def markdown(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Write a table."""
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cells(made: str) -> Rows:
    """Return the rows of all tables of a text, their heads too; a line of prose is a row of one cell."""
    lines = [line for line in made.splitlines() if line.strip("|- ")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def part(rows: list[dict[str, str]], *heads: str) -> str:
    """Write some columns of rows, or all."""
    names = heads or tuple(rows[0])
    return markdown(names, [tuple(row[name] for name in names) for row in rows])


def kept(script: str) -> Rows:
    """Return all rows that a script has written beside it."""
    with Path(__file__).with_name(f"{script}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def records(rows: Rows, *heads: str) -> list[dict[str, str]]:
    """Return the rows of one table, by the names of its columns, of which the first are given."""
    start = next(i for i, row in enumerate(rows) if tuple(row[: len(heads)]) == heads)
    own = list(takewhile(lambda row: len(row) == len(rows[start]), rows[start:]))
    return [dict(zip(own[0], row, strict=True)) for row in own[1:]]
