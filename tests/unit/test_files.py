"""What is written: through devices, FIFOs and links as Unix tools do it, whole or not at all, in every format."""

import os
import re
import stat
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.io import loadmat

import narrows as nw
from narrows.base.files import is_stream, matlab_of, save_dataset, save_figure, write_whole
from narrows.report.fit_page import write_report
from narrows.report.voyage_figures import voyage_figure
from tables import short_twin

DTC = nw.published("mikkelsen2025_dtc")
WAY = nw.straight_waterway(DTC.configuration.canal, 100.0)
pytestmark = pytest.mark.skipif(os.name != "posix", reason="devices, FIFOs and links are those of Unix")


@cache
def voyage() -> nw.Voyage:
    return nw.simulate(DTC, 0.5, duration=2.0)


@cache
def plan() -> nw.Plan:
    return nw.plan_tests(DTC.configuration, 2, tank=nw.Tank(speeds=[0.9]))


@cache
def fit() -> nw.Fit:
    return nw.identify(short_twin())


WRITERS: dict[str, Callable[[Path], object]] = {
    ".nc": lambda path: voyage().save(path),
    ".png": lambda path: save_figure(voyage_figure(voyage()), path),
    ".toml": lambda path: nw.save_model(DTC, path),
    ".html": lambda path: write_report({"": fit()}, path, "title"),
    ".geojson": lambda path: nw.write_waterway(replace(WAY, origin=(32.6, 30.0)), path),
    ".csv": lambda path: plan().save(path),
}


@contextmanager
def umask(mode: int) -> Iterator[None]:
    before = os.umask(mode)
    try:
        yield
    finally:
        os.umask(before)


def received(fifo: Path, write: Callable[[], object]) -> bytes:
    os.mkfifo(fifo)
    heard: list[bytes] = []
    reader = threading.Thread(target=lambda: heard.append(fifo.read_bytes()), daemon=True)
    reader.start()
    write()
    reader.join(10)
    return b"".join(heard)


@pytest.mark.parametrize("suffix", WRITERS)
def test_every_format_goes_through_a_link_to_a_device(suffix: str, tmp_path: Path) -> None:
    link = tmp_path / f"null{suffix}"
    link.symlink_to(os.devnull)
    WRITERS[suffix](link)
    assert link.is_symlink()
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)
    assert list(tmp_path.iterdir()) == [link]


@pytest.mark.parametrize("suffix", WRITERS)
def test_every_format_goes_into_a_fifo(suffix: str, tmp_path: Path) -> None:
    fifo, file = tmp_path / f"fifo{suffix}", tmp_path / f"file{suffix}"
    WRITERS[suffix](file)
    heard = received(fifo, lambda: WRITERS[suffix](fifo))
    assert stat.S_ISFIFO(fifo.stat().st_mode)
    assert len(heard) == file.stat().st_size > 100


@pytest.mark.parametrize("suffix", WRITERS)
def test_every_format_leaves_the_mode_to_the_umask(suffix: str, tmp_path: Path) -> None:
    with umask(0o027):
        WRITERS[suffix](tmp_path / f"new{suffix}")
    assert [stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()] == [0o640]


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path: Path) -> None:
    target, link, other = tmp_path / "target", tmp_path / "link", tmp_path / "link to the link"
    target.write_text("old")
    target.chmod(0o604)
    link.symlink_to("target")
    other.symlink_to(link)
    write_whole(other, "new")
    assert (target.read_text(), link.is_symlink(), other.is_symlink()) == ("new", True, True)
    assert stat.S_IMODE(target.stat().st_mode) == 0o604
    assert len(list(tmp_path.iterdir())) == 3


def test_a_link_to_nothing_makes_what_it_leads_to(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "target").read_text() == "new"
    assert (tmp_path / "link").is_symlink()


SAY = "import sys; from narrows.base.files import write_whole as w; print('a'); w(sys.argv[1], 'then\\n'); print('end')"


@pytest.mark.parametrize("name", ["/dev/stdout", "/dev/fd/1", "link"])
@pytest.mark.parametrize("to_file", [False, True], ids=["pipe", "file"])
def test_standard_output_keeps_its_order(name: str, to_file: bool, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/dev/stdout")
    words, file = [sys.executable, "-c", SAY, name], tmp_path / "out"
    if to_file:
        with file.open("w") as out:
            subprocess.run(words, cwd=tmp_path, stdout=out, check=True)
        said = file.read_text()
    else:
        said = subprocess.run(words, cwd=tmp_path, stdout=subprocess.PIPE, text=True, check=True).stdout
    assert said == "a\nthen\nend\n"


def test_models_of_several_conditions_go_into_one_device(tmp_path: Path) -> None:
    from narrows.cli.fits import publish
    from narrows.cli.options import Delivery

    fits = {"a": fit(), "b/c": fit()}
    reader, writer = os.pipe()
    publish(fits, "t", Delivery(Path(f"/dev/fd/{writer}")))
    os.close(writer)
    with open(reader, encoding="utf-8") as file:
        assert file.read().count("[ship]") == 2
    publish(fits, "t", Delivery(tmp_path / "m.toml"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m-a.toml", "m-b%2Fc.toml"]


@pytest.mark.parametrize("call", ["open", "replace", "chmod"])
def test_whole_or_not_at_all(call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that fills at any moment leaves the old file and nothing beside it."""
    path = tmp_path / "file"
    path.write_text("old")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    def opened(path: Path, mode: str) -> None:
        path.touch()
        full()

    place = {"open": "Path.open", "replace": "os.replace", "chmod": "Path.chmod"}[call]
    with monkeypatch.context() as spoilt:
        spoilt.setattr(f"narrows.base.files.{place}", opened if call == "open" else full)
        with pytest.raises(nw.InputError, match=r"file: cannot be written \(No space left on device\)"):
            write_whole(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupt_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("narrows.base.files.os.replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "file", "new")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("folder", "Is a directory"), ("absent/file", "No such file"), ("loop", "Too many levels"), ("a\0b", "null"),
        ("full", "No space left"), ("\ud800", "surrogates not allowed"), ("x" * 300, "too long"),
    ],
)  # fmt: skip
def test_what_cannot_be_written_is_said(name: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "full").symlink_to("/dev/full")
    with pytest.raises(nw.InputError, match=f"cannot be written .*{said}"):
        write_whole(tmp_path / name, "new")
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize("labels", [[10**12, 1], [(1, 2), "a"]])
def test_labels_that_the_format_does_not_hold(labels: list, tmp_path: Path) -> None:
    coordinate = np.empty(2, object) if not isinstance(labels[0], int) else np.array(labels)
    coordinate[:] = labels
    dataset = xr.Dataset({"u": ("ship", [0.5, 1.0])}, coords={"ship": coordinate})
    with pytest.raises(nw.InputError, match="NetCDF does not hold these labels"):
        save_dataset(dataset, tmp_path / "fleet.nc")
    assert not list(tmp_path.iterdir())


def test_columns_of_one_name_in_matlab_are_refused() -> None:
    with pytest.raises(nw.InputError, match="not all different"):
        matlab_of({"a-b": [1.0], "a_b": [2.0]})
    assert {"column5_deg", "column"} <= set(loadmat(BytesIO(matlab_of({"5_deg": [1.0], "ψ": [2.0]}))))


def test_a_name_as_long_as_names_may_be(tmp_path: Path) -> None:
    write_whole(tmp_path / ("x" * 255), "new")
    assert (tmp_path / ("x" * 255)).read_text() == "new"


def test_streams_are_told_from_files(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert [is_stream(path) for path in (os.devnull, "/dev/stdout")] == [True, True]
    assert [is_stream(path) for path in (tmp_path, tmp_path / "file", tmp_path / "absent", "\0")] == [False] * 4


ELSEWHERE = {"assembly.py", "cache.py", "fmu.py", "ship_files.py"}
"""Writers of what no user names a file for: the cache, the folders of stores, an archive in memory,
sources that a compiler is given."""
WRITING = re.compile(
    r"\.write_(text|bytes)\(|(?<!def )\bto_(netcdf|csv|json|parquet|html)\([^)]*path|open\([^)]*[\"'][wax]b?[\"']"
)


def test_there_is_no_other_door() -> None:
    sources = Path(nw.__file__).parent.rglob("*.py")
    found = {path.name for path in sources if WRITING.search(path.read_text(encoding="utf-8"))}
    assert found - ELSEWHERE == {"files.py"}
