"""Puts what a script of this folder computes between its two marks on a page of the docs."""

import sys
from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"
END = "<!-- end -->"


def publish(script: str, page: str, made: str) -> None:
    """Print what was computed; with --write put it on its page too."""
    print(made)
    if "--write" not in sys.argv:
        return
    path, start = DOCS / page, f"<!-- made by decisions/{Path(script).name} -->"
    before, mark, rest = path.read_text(encoding="utf-8").partition(start)
    if not mark:
        raise SystemExit(f"{path} has no mark {start}")
    path.write_text(f"{before}{start}\n{made}\n{END}{rest.partition(END)[2]}", encoding="utf-8")


def markdown(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Write a table."""
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
