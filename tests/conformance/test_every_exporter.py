"""Every exporter of ``EXPORTERS``: its files, its verb, its refusals, its passport; coefficients and options count."""

import gzip
import re
import tarfile
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import narrows as nw
import narrows.export.fmu
from export.exported import bent, model_of
from narrows.cli import app
from narrows.export import EXPORTERS, passport
from narrows.export.page import assembly

every_kind = pytest.mark.parametrize("kind", EXPORTERS)
MODEL = "mikkelsen2025_dtc"
# A value of each option that is not its own.
OTHERS = {
    "waterway": bent("steered"), "surge": "free", "surge_inertia": 300.0, "coriolis": True, "contact": "midship",
    "fmi": 3, "u": 0.77, "dt": 0.03, "title": "another title", "controller": nw.ConstantRudder(0.1),
}  # fmt: skip


@every_kind
def test_the_verb_writes_what_the_function_does(kind: str, tmp_path: Path) -> None:
    own = EXPORTERS[kind]
    by_verb, by_function = (tmp_path / folder / f"ship{own.suffixes[0]}" for folder in ("verb", "function"))
    by_verb.parent.mkdir()
    by_function.parent.mkdir()
    done = CliRunner().invoke(app, ["export", kind, MODEL, "-o", str(by_verb)])
    assert done.exit_code == 0, done.output
    assert done.stdout.endswith(f"wrote {by_verb}\n")
    written = nw.export.write(nw.published(MODEL), by_function, kind)
    assert all(note in done.stdout for note in own.notes(written))
    assert by_function.stat().st_size > 500
    assert by_verb.read_bytes() == by_function.read_bytes(), "written again it is another file"


@every_kind
def test_a_file_of_another_kind_is_refused_and_not_written(kind: str, tmp_path: Path) -> None:
    others = {one.suffixes[0] for one in EXPORTERS.values()} - {*EXPORTERS[kind].suffixes}
    for name in ("ship.f", "ship", *(f"ship{suffix}" for suffix in sorted(others))):
        with pytest.raises(nw.InputError):
            nw.export.write(nw.published(MODEL), tmp_path / name, kind)
    assert list(tmp_path.iterdir()) == []


@every_kind
def test_the_help_names_it_and_python_gives_it(kind: str) -> None:
    own, shown = EXPORTERS[kind], CliRunner().invoke(app, ["export", "--help"]).stdout
    assert repr(kind) in shown
    words = [word.rstrip(",.") for word in shown.split()]
    assert {suffix: words.count(suffix) for suffix in own.suffixes} == dict.fromkeys(own.suffixes, 1)
    assert own.words
    described = re.search(rf"\b{kind} \((.*?)\)", " ".join((nw.export.write.__doc__ or "").split()))
    assert described, "name it in the docstring of write"
    assert sorted(described[1].split(", ")) == sorted(f"``{suffix}``" for suffix in own.suffixes)


def contents(kind: str, folder: Path, model: nw.Model, suffix: str = "", **options: Any) -> bytes:
    """What a file holds; what an archive holds, member by member."""
    path = folder / f"ship{suffix or EXPORTERS[kind].suffixes[0]}"
    nw.export.write(model, path, kind, **options)
    if tarfile.is_tarfile(path):
        return gzip.decompress(path.read_bytes())
    if not zipfile.is_zipfile(path):
        return path.read_bytes()
    with zipfile.ZipFile(path) as packed:
        return b"".join(packed.read(name) for name in packed.namelist() if not name.startswith("binaries"))


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(narrows.export.fmu, "builds_here", lambda fmi: ())
    monkeypatch.setattr(assembly, "lacks_zig", lambda what: "left out")


@every_kind
def test_every_coefficient_of_the_bank_counts(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, uncompiled: None
) -> None:
    """In what is computed, not in the passport alone."""
    monkeypatch.setattr(passport, "model_hash", lambda model: "")
    monkeypatch.setattr(passport, "_coefficients", lambda model: iter(()))
    model = nw.published(MODEL)
    before = contents(kind, tmp_path, model)
    for name in (term.name for term in model.terms.terms if term.from_bank):
        assert contents(kind, tmp_path, model.with_coefficients({name: 1.01 * model[name]})) != before, name


@every_kind
def test_every_option_counts(kind: str, tmp_path: Path, uncompiled: None) -> None:
    model, exporter = model_of("steered"), EXPORTERS[kind]
    asked = exporter.options
    assert {*asked} <= OTHERS.keys(), "give each option another value in OTHERS"

    def files(**options: Any) -> list[bytes]:
        return [contents(kind, tmp_path, model, suffix, **options) for suffix in exporter.suffixes]

    plain, free = files(), files(surge="free") if "surge" in asked else []
    for name in asked:
        if name == "surge_inertia":  # It counts where the surge is free.
            assert files(surge="free", surge_inertia=OTHERS[name]) != free
        else:
            after = free if OTHERS[name] == "free" else files(**{name: OTHERS[name]})
            assert after != plain, name


@every_kind
def test_it_carries_the_passport_of_its_model(kind: str, tmp_path: Path, uncompiled: None) -> None:
    """Intervals and covariance too, by numbers written out again here."""
    model, half = nw.published(MODEL), 0.01 * np.arange(1.0, len(nw.PAPER) + 1.0)
    root = np.tril(np.full((len(half), len(half)), 0.3)) + np.diag(half)
    model = replace(model, covariance=root @ root.T)
    text = contents(kind, tmp_path, model).decode()
    ends = [model["b_bank"] + sign * 1.95996 * np.sqrt(model.covariance.diagonal()[model.terms.names.index("b_bank")])
            for sign in (-1, 1)]  # fmt: skip
    parts = (
        passport.model_hash(model), passport.LICENCE, model.source.text.split(",")[0],
        f"b_bank = {model['b_bank']:.4g} ({ends[0]:.4g} to {ends[1]:.4g})",
        *(f"{value:.9g}" for value in model.covariance[np.tril_indices(len(half))]),
    )  # fmt: skip
    assert [part for part in parts if part not in text] == []


@pytest.mark.parametrize("kind", [kind for kind, own in EXPORTERS.items() if "waterway" not in own.options])
@pytest.mark.parametrize(("option", "name"), [("--waterway", "waterway"), ("--hold", "controller")])
def test_what_it_refuses_to_be_told(kind: str, option: str, name: str, tmp_path: Path) -> None:
    path = tmp_path / f"ship{EXPORTERS[kind].suffixes[0]}"
    given = str(Path(nw.__file__).parents[2] / "examples/waterway.geojson") if name == "waterway" else "0"
    done = CliRunner().invoke(app, ["export", kind, "estimated_kcs", "-o", str(path), option, given])
    assert str(done.exception) == f"a file of kind {kind} has no {name} of its own to set; leave {option} out"
    assert not path.exists()


def test_an_unknown_kind_is_refused(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["export", "fortran", MODEL, "-o", str(tmp_path / "ship.f")])
    assert isinstance(done.exception, nw.InputError)
    assert all(kind in str(done.exception) for kind in EXPORTERS)
