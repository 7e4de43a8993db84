"""What is published is what is tested: one version, extras that exist, and a machine that is looked at first."""

import importlib.metadata
import re
import runpy
import tomllib
from pathlib import Path
from typing import Any

import pytest

import narrows as nw
from narrows.base.errors import installing, libraries_of, needs

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
MACHINE = runpy.run_path(str(ROOT / "requirements" / "check_machine.py"))
CALLED = ("check.yml", "site.yml")
BUILD = {"editables", "hatchling", "pathspec", "pluggy", "tomlkit", "trove-classifiers"}
"""What a checkout is built with, which users of the package do not install."""
GOOD: dict[str, Any] = {
    "version": (3, 12, 1), "bits": 64, "processor": "x86_64", "free": 9e9, "libc": "glibc", "lacks": [],
}  # fmt: skip


def test_the_version_stands_in_one_place(cli) -> None:
    assert PROJECT["project"]["dynamic"] == ["version"]
    assert "version" not in PROJECT["project"]
    assert PROJECT["tool"]["hatch"]["version"]["path"] == "src/narrows/__init__.py"
    assert cli("--version") == (0, f"narrows {nw.__version__}\n", "")
    assert f"version: {nw.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"badge/version-{nw.__version__}-" in (ROOT / "README.md").read_text(encoding="utf-8")
    first = re.search(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert first[1] == nw.__version__
    assert f"narrows {nw.__version__}" in (ROOT / "docs" / "release-note.md").read_text(encoding="utf-8")


def test_a_sound_machine_is_passed() -> None:
    assert MACHINE["faults"](**GOOD) == []
    assert MACHINE["faults"]() == []
    assert MACHINE["notes"]((3, 15, 0)) == []


FAULTS = {
    "an old Python": ({"version": (3, 9, 2)}, r"this is Python 3.9 and narrows needs 3.11 or newer: make PYTHON="),
    "no venv": ({"lacks": ["ensurepip"]}, r"has no ensurepip: .* apt install python3-venv"),
    "32 bits": ({"bits": 32}, r"64 bits on x86 and ARM, this is 32 bits"),
    "another processor": ({"processor": "riscv64"}, r"64 bits on riscv64"),
    "musl": ({"libc": "musl"}, r"compiled for glibc"),
    "a full disk": ({"free": 2e8}, r"0.2 GB are free here and the environment takes 1.5: make room"),
}


@pytest.mark.parametrize("case", FAULTS)
def test_what_is_wrong_with_a_machine_is_said(case: str) -> None:
    changed, said = FAULTS[case]
    (sentence,) = MACHINE["faults"](**{**GOOD, **changed})
    assert re.search(said, sentence)


def test_a_python_newer_than_those_tried_is_said_and_tried() -> None:
    assert "tried up to 3.15" in MACHINE["notes"]((3, 16, 0))[0]


def test_the_pythons_that_are_tried_are_those_that_are_named() -> None:
    versions = [c.rpartition(" ")[2] for c in PROJECT["project"]["classifiers"] if "Python :: 3." in c]
    assert (
        MACHINE["dotted"](MACHINE["OLDEST"]) == versions[0] == PROJECT["project"]["requires-python"].removeprefix(">=")
    )
    assert MACHINE["dotted"](MACHINE["NEWEST"]) == versions[-1]


def test_the_machine_is_looked_at_before_anything_is_downloaded() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    recipe = makefile.split(".venv/base: ")[1]
    assert "INSTALL := -m pip install" in makefile
    assert 0 < recipe.index("check_machine.py") < recipe.index("$(INSTALL)")


def test_every_extra_that_is_asked_for_exists() -> None:
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.py"))
    asked = set(re.findall(r"""(?:needs|libraries_of)\(["'](\w+)""", sources))
    assert asked == set(PROJECT["project"]["optional-dependencies"])


def test_the_hint_installs_what_an_extra_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = ["numpy>=2", "pyogrio>=0.10; extra == 'charts'", "shapely>=2.0; extra == 'charts'", "zarr; extra == 'x'"]
    monkeypatch.setattr("narrows.base.errors.requires", lambda name: lines)
    assert libraries_of("charts") == ["pyogrio>=0.10", "shapely>=2.0"]
    command = r"^a chart needs pyogrio and shapely: \S*python\S* -m pip install 'pyogrio>=0.10' 'shapely>=2.0'$"
    with pytest.raises(nw.InputError, match=command), needs("charts", "a chart"):
        raise ImportError(name="pyogrio")

    def unknown(name: str) -> list[str]:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr("narrows.base.errors.requires", unknown)
    assert libraries_of("charts") == []
    assert installing(["a>=1"]).endswith(" -m pip install 'a>=1'")


def test_the_workflows_run_what_a_change_must_pass_on_the_oldest_python_and_the_newest() -> None:
    check, site = ((ROOT / ".github" / "workflows" / name).read_text(encoding="utf-8") for name in CALLED)
    oldest = PROJECT["project"]["requires-python"].removeprefix(">=")
    assert f'python: ["{oldest}", "3.x"]' in check
    assert "run: .ci/run\n" in check
    assert "run: make docs\n" in site
    assert "path: out/site\n" in site


def test_every_mandatory_dependency_has_its_line() -> None:
    text = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8").split("## Dependencies")[1]
    named = re.findall(r"^\| ([a-z0-9-]+) \|", text.split("| extra |")[0], re.MULTILINE)
    needed = [re.split(r"[^\w-]", library)[0] for library in PROJECT["project"]["dependencies"]]
    assert [name for name in named if name != "library"] == needed
    locked = (ROOT / "requirements" / "base.txt").read_text(encoding="utf-8")
    installed = set(re.findall(r"^([a-z0-9-]+)==", locked, re.MULTILINE)) - BUILD
    assert f"The base install has {len(installed)} packages" in text
