"""The docs' console blocks are held to what they show: each way to be wrong is told."""

from pathlib import Path

import pytest

import console

PRINTED = "first\nsecond 1.5 m\n\nthird   \n"


@pytest.mark.parametrize(
    "shown",
    [
        ("first", "second 1.5 m", "", "third"),
        ("...", "third"),
        ("first", "..."),
        ("...",),
        ("first", "...", "second ... m", "...", "third"),
    ],
)
def test_what_agrees(shown: tuple[str, ...]) -> None:
    assert console.agrees(shown, PRINTED)


@pytest.mark.parametrize(
    "shown",
    [
        ("first",),
        ("first", "third"),
        ("...", "second 1.5 m"),
        ("...", "third", "second 1.5 m"),
        ("...", "second", "..."),
        ("first ... third",),
        ("...", "fourth", "..."),
    ],
)
def test_what_does_not(shown: tuple[str, ...]) -> None:
    assert not console.agrees(shown, PRINTED)


def test_a_block_is_taken_apart() -> None:
    first, second, third = console.commands(
        "$ a b   # your files\n$ c    # exit 2\nsaid\n\nmore\n$ d # not run: the ship's own day\n"
    )
    assert (first.exit_code, first.shown, first.comment) == (0, (), "your files")
    assert (second.exit_code, second.shown) == (2, ("said", "", "more"))
    assert (first.runs, second.runs, third.runs) == (True, True, False)


def test_no_line_stands_before_the_first_command() -> None:
    with pytest.raises(AssertionError, match="begins with a command"):
        list(console.commands("a b\n"))


@pytest.mark.parametrize(
    ("block", "wrong"),
    [
        ("$ sh -c 'exit 2'", "exit code 2, not 0"),
        ("$ true  # exit 2", "exit code 0, not 2"),
        ("$ echo this\nthat", "the page shows\nthat\nbut"),
    ],
)
def test_a_page_that_is_wrong_fails(block: str, wrong: str, tmp_path: Path) -> None:
    (command,) = console.commands(block)
    with pytest.raises(AssertionError, match=wrong):
        console.run(command, tmp_path)


def test_commands_run_in_the_folder_of_their_page(tmp_path: Path) -> None:
    for command in console.commands("$ sh -c 'echo found > file'\n$ cat file\nfound\n"):
        console.run(command, tmp_path)
    assert (tmp_path / "file").read_text() == "found\n"
