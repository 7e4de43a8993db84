"""Every exporter of ``EXPORTERS``: its files, its verb, its refusals; and a test that runs what it writes."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import narrows as nw
from narrows.cli import app
from narrows.export.exporters import EXPORTERS

every_kind = pytest.mark.parametrize("kind", EXPORTERS)
TESTS = Path(__file__).parents[1] / "export"
MODEL = "mikkelsen2025_dtc"


@every_kind
def test_the_verb_writes_what_the_function_does(kind: str, tmp_path: Path) -> None:
    own = EXPORTERS[kind]
    by_verb, by_function = (tmp_path / folder / f"ship{own.suffixes[0]}" for folder in ("verb", "function"))
    by_verb.parent.mkdir()
    by_function.parent.mkdir()
    done = CliRunner().invoke(app, ["export", kind, MODEL, "-o", str(by_verb)])
    assert done.exit_code == 0, done.output
    assert done.stdout.endswith(f"wrote {by_verb}\n")
    written = own.write(nw.published(MODEL), by_function)
    assert all(note in done.stdout for note in own.notes(written))
    assert by_function.stat().st_size > 500
    assert by_verb.read_bytes() == by_function.read_bytes(), "written again it is another file"


@every_kind
def test_a_file_of_another_kind_is_refused_and_not_written(kind: str, tmp_path: Path) -> None:
    others = {one.suffixes[0] for one in EXPORTERS.values()} - {*EXPORTERS[kind].suffixes}
    for name in ("ship.f", "ship", *(f"ship{suffix}" for suffix in sorted(others))):
        with pytest.raises(nw.InputError):
            EXPORTERS[kind].write(nw.published(MODEL), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@every_kind
def test_the_help_names_it_and_python_gives_it(kind: str) -> None:
    own, shown = EXPORTERS[kind], CliRunner().invoke(app, ["export", "--help"]).stdout
    assert repr(kind) in shown
    assert own.suffixes[0] in shown
    assert getattr(nw.export, own.write.__name__) is own.write
    assert own.words


@every_kind
def test_a_test_runs_what_it_writes(kind: str) -> None:
    """Beside the plain step: how a language is run is for that test to know."""
    name = EXPORTERS[kind].write.__name__
    assert any(name in path.read_text(encoding="utf-8") for path in TESTS.glob("*.py")), (
        f"no test in {TESTS} has {name}"
    )


def test_an_unknown_kind_is_refused(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["export", "fortran", MODEL, "-o", str(tmp_path / "ship.f")])
    assert isinstance(done.exception, nw.InputError)
    assert all(kind in str(done.exception) for kind in EXPORTERS)
