"""Ensembles on disk: the same answer, resumed after a stop, and on a cluster whose worker is killed."""

import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from narrows.simulation import store

pytest.importorskip("zarr", reason="stores need the cluster extra")
pytestmark = pytest.mark.filterwarnings("ignore")
Y = np.linspace(-2.5, 2.5, 64)
U = np.linspace(0.8, 1.2, 8)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "TASK_VESSELS", 64)


def same(stored, here) -> None:
    for name in here.data_vars:
        np.testing.assert_array_equal(stored[name].to_numpy(), here[name].to_numpy())


@pytest.mark.usefixtures("small")
def test_a_store_holds_the_same_answer(dtc: nw.Model, tmp_path: Path) -> None:
    stored = nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=tmp_path / "fleet.zarr")
    assert stored.attrs["complete"] == 1
    here = nw.ensemble(dtc, y=Y, u=U, duration=20.0)
    same(stored, here)
    assert (
        "too long" in nw.ensemble(dtc, y=Y, u=U, duration=20.0, dt=2.0, store=tmp_path / "coarse.zarr").attrs["notes"]
    )
    assert stored.attrs["notes"] == here.attrs["notes"] != ""


@pytest.mark.usefixtures("small")
def test_a_stopped_run_goes_on(dtc: nw.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, ran = store.run_block, []

    def run(*words):
        if len(ran) == 3:
            raise KeyboardInterrupt
        ran.append(words[-1])
        return real(*words)

    monkeypatch.setattr(store, "run_block", run)
    first = nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=tmp_path / "fleet.zarr")
    assert first.attrs["complete"] == 0
    monkeypatch.setattr(store, "run_block", lambda *words: ran.append(words[-1]) or real(*words))
    second = nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=tmp_path / "fleet.zarr")
    assert second.attrs["complete"] == 1
    assert sorted(ran) == list(range(8))
    same(second, nw.ensemble(dtc, y=Y, u=U, duration=20.0))


def test_another_ensemble_is_not_overwritten(dtc: nw.Model, tmp_path: Path) -> None:
    nw.ensemble(dtc, y=[0.5, 1.0], duration=5.0, store=tmp_path / "fleet.zarr")
    with pytest.raises(nw.InputError, match="another ensemble"):
        nw.ensemble(dtc, y=[0.5, 1.1], duration=5.0, store=tmp_path / "fleet.zarr")


def ships(*labels: str) -> xr.DataArray:
    return xr.DataArray([0.5, 1.0, 1.5], dims="ship", coords={"ship": list(labels)})


def test_labels_are_those_asked_for_now(dtc: nw.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The voyages are the same under any label, so none runs again; on disk the labels change too."""
    path = tmp_path / "fleet.zarr"
    first = nw.ensemble(dtc, y=ships("a", "b", "c"), duration=5.0, store=path).load()
    monkeypatch.setattr(store, "run_block", None)
    for labels in (ships("b", "a", "longer"), ships("a", "b", "c").drop_vars("ship"), ships("d", "e", "f")):
        again = nw.ensemble(dtc, y=labels, duration=5.0, store=path)
        for held in (again, xr.open_zarr(path, consolidated=False)):
            xr.testing.assert_equal(xr.Dataset(coords=held.coords), xr.Dataset(coords=labels.coords))
            same(first, held.drop_vars("block_checksum", errors="ignore"))


KILLED = """
import os, random, signal, sys, time
from pathlib import Path
import numpy as np
import narrows as nw
from narrows.simulation import store

store.TASK_VESSELS = 64
model, folder = nw.published("mikkelsen2025_dtc"), Path(sys.argv[1])
vary = dict(y=np.linspace(-2.5, 2.5, 64), u=np.linspace(0.8, 1.2, 4), duration=20.0)
right = nw.ensemble(model, **vary).time.to_numpy()


def sailing(path):
    "A process of its own, with all of the package in memory: only the store's first moments are left to kill it in."
    child = os.fork()
    if child == 0:
        try:
            found = nw.ensemble(model, **vary, store=path)
            os._exit(0 if found.attrs["complete"] == 1 and (found.time.to_numpy() == right).all() else 1)
        except BaseException as error:
            print(path.name, type(error).__name__, error, flush=True)
            os._exit(1)
    return child


def code(child):
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


start = time.perf_counter()
assert code(sailing(folder / "whole")) == 0
whole, killed, tried, wanted = time.perf_counter() - start, 0, 0, int(sys.argv[2])
while killed < wanted and tried < 5 * wanted:
    child = sailing(folder / str(tried))
    time.sleep(whole * (killed + 0.5) / wanted)
    os.kill(child, signal.SIGKILL)
    if code(child) == -signal.SIGKILL:
        killed += 1
    else:
        whole *= 0.8  # it was done before: this machine has grown quicker
    assert code(sailing(folder / str(tried))) == 0, tried
    tried += 1
print(killed)
"""


@pytest.mark.slow
@pytest.mark.parametrize("kills", ["4", "12"])
def test_killed_at_any_moment_it_goes_on(tmp_path: Path, kills: str) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", KILLED, tmp_path, kills], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip() == kills


@pytest.fixture(scope="module")
def whole(dtc: nw.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "fleet.zarr"
    with pytest.MonkeyPatch.context() as small:
        small.setattr(store, "TASK_VESSELS", 64)
        nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=path)
    return path


def cut(content: bytes, chance: random.Random) -> bytes:
    return content[: chance.randrange(len(content))] if content else b""


DAMAGE = {
    "cut short": cut,
    "empty": lambda content, chance: b"",
    "zeros": lambda content, chance: bytes(len(content)),
    "garbage": lambda content, chance: chance.randbytes(len(content) + chance.randrange(9)),
    "one bit": lambda content, chance: (
        int.from_bytes(content, "little") ^ 1 << chance.randrange(8 * len(content))
    ).to_bytes(len(content), "little"),
    "missing": None,
}


def reopened(dtc: nw.Model, path: Path) -> xr.Dataset | str:
    try:
        return nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=path)
    except nw.InputError as error:
        return str(error)


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("kind", DAMAGE)
def test_what_is_damaged_runs_again(kind: str, whole: Path, dtc: nw.Model, tmp_path: Path) -> None:
    """Chunks, labels, metadata: any files at all, but that which says whose the folder is; that one may be refused."""
    chance, right, refused = random.Random(kind), nw.ensemble(dtc, y=Y, u=U, duration=20.0), 0
    files = sorted(path.relative_to(whole) for path in whole.rglob("*") if path.is_file())
    for number in range(8):
        path = shutil.copytree(whole, tmp_path / str(number))
        struck = chance.sample(files, chance.choice([1, 1, 3, 20]))
        for name in struck:
            (path / name).unlink() if DAMAGE[kind] is None else (path / name).write_bytes(
                DAMAGE[kind]((path / name).read_bytes(), chance)
            )
        found = reopened(dtc, path)
        if isinstance(found, str):
            assert Path("zarr.json") in struck, found
            assert "choose another folder or remove it" in found
            refused += 1
            continue
        assert found.attrs["complete"] == 1
        xr.testing.assert_equal(xr.Dataset(coords=found.coords), xr.Dataset(coords=right.coords))
        same(found, right)
    assert refused < 5


@pytest.mark.parametrize("held", ["a file", "something else", "an empty folder"])
def test_what_stands_there_already(held: str, dtc: nw.Model, tmp_path: Path) -> None:
    path = tmp_path / "fleet.zarr"
    if held == "a file":
        path.write_text("mine")
    else:
        path.mkdir()
    if held == "something else":
        (path / "thesis.tex").write_text("mine")
    if held == "an empty folder":
        assert nw.ensemble(dtc, y=[0.5, 1.0], duration=5.0, store=path).attrs["complete"] == 1
        return
    with pytest.raises(nw.InputError, match="holds no ensemble that can be read; choose another folder"):
        nw.ensemble(dtc, y=[0.5, 1.0], duration=5.0, store=path)
    assert len(list(tmp_path.rglob("*"))) == (1 if path.is_file() else 2)


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("name", ["store.os.replace", "store._make_columns", "store.run_block"])
def test_a_disk_that_is_full_is_said(name: str, dtc: nw.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(f"narrows.simulation.{name}", full)
    with pytest.raises(nw.InputError, match=r"fleet.zarr: cannot be written \(No space left on device\)"):
        nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=tmp_path / "fleet.zarr")
    monkeypatch.undo()
    assert nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=tmp_path / "fleet.zarr").attrs["complete"] == 1


def test_what_killed_processes_left_is_swept_and_what_others_make_is_not(dtc: nw.Model, tmp_path: Path) -> None:
    old, new = tmp_path / ".narrows-store-old", tmp_path / ".narrows-store-new"
    old.mkdir()
    new.mkdir()
    os.utime(old, (0, 0))
    nw.ensemble(dtc, y=[0.5, 1.0], duration=2.0, store=tmp_path / "fleet.zarr")
    assert sorted(path.name for path in tmp_path.iterdir()) == [".narrows-store-new", "fleet.zarr"]


@pytest.mark.slow
def test_a_cluster_survives_the_loss_of_a_worker(dtc: nw.Model, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="clusters need the cluster extra")
    y, u = np.linspace(-2.5, 2.5, 1000), np.linspace(0.8, 1.2, 1000)
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        victim = next(iter(client.run(os.getpid).values()))
        path = tmp_path / "fleet.zarr"

        def kill_once_begun() -> None:
            while not path.exists():
                time.sleep(0.01)
            time.sleep(0.5)
            os.kill(victim, signal.SIGKILL)

        killer = threading.Thread(target=kill_once_begun)
        killer.start()
        stored = nw.ensemble(dtc, y=y, u=u, duration=20.0, store=path, client=client)
        killer.join()
    assert stored.attrs["complete"] == 1
    same(stored, nw.ensemble(dtc, y=y, u=u, duration=20.0))
