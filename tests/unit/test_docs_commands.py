"""Commands of README and docs have verbs and options that exist; the slow ones run in the whole suite alone."""

import re
import shlex
from pathlib import Path

import click
import pytest

import console
from narrows.cli.app import app

ROOT = Path(__file__).parents[2]
EVERYWHERE = {"--help", "--verbose", "--debug", "--version"}
BLOCK = re.compile(r"^```console\n(.*?)^```", re.DOTALL | re.MULTILINE)


def written(page: Path) -> list[list[str]]:
    """Words of each command of a page that starts narrows."""
    commands = [one for block in BLOCK.findall(page.read_text(encoding="utf-8")) for one in console.commands(block)]
    words = [shlex.split(one.text, comments=True) for one in commands]
    return [line[1:] for line in words if line[0] == "narrows"]


def command_of(words: list[str]) -> click.Command:
    found = app.commands[words[0]]
    return found.commands[words[1]] if isinstance(found, click.Group) else found


def unknown_options(words: list[str]) -> set[str]:
    given = {word.partition("=")[0] for word in words if re.match("--?[a-z]", word)}
    known = {
        option for parameter in command_of(words).params for option in (*parameter.opts, *parameter.secondary_opts)
    }
    return given - known - EVERYWHERE


PAGES = {
    page: lines for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))) if (lines := written(page))
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_verbs_and_options_exist(page: Path) -> None:
    assert {" ".join(words): gone for words in PAGES[page] if (gone := unknown_options(words))} == {}


def test_an_option_that_is_gone_is_found() -> None:
    assert unknown_options(["simulate", "mikkelsen2025_dtc", "--y", "-0.5", "--velocity=1"]) == {"--velocity"}
    with pytest.raises(KeyError):
        unknown_options(["sail", "mikkelsen2025_dtc"])
