"""Ensembles on disk: the same answer, resumed after a stop, and on a cluster whose worker is killed."""

import os
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
from narrows.simulation import grid as store

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
    """The voyages are the same under any label, so none runs again."""
    path = tmp_path / "fleet.zarr"
    first = nw.ensemble(dtc, y=ships("a", "b", "c"), duration=5.0, store=path).load()
    monkeypatch.setattr(store, "run_block", None)
    for labels in (ships("b", "a", "longer"), ships("a", "b", "c").drop_vars("ship"), ships("d", "e", "f")):
        again = nw.ensemble(dtc, y=labels, duration=5.0, store=path)
        xr.testing.assert_equal(xr.Dataset(coords=again.coords), xr.Dataset(coords=labels.coords))
        same(first, again)


KILLED = """
import os, random, signal, sys, time
from pathlib import Path
import numpy as np
import narrows as nw
from narrows.simulation import grid as store

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
@pytest.mark.parametrize("name", ["grid.os.replace", "grid._write_empty", "grid.run_block"])
def test_a_disk_that_is_full_is_said(name: str, dtc: nw.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as disk:
        disk.setattr(f"narrows.simulation.{name}", full)
        with pytest.raises(nw.InputError, match=r"fleet.zarr: cannot be written \(No space left on device\)"):
            nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=tmp_path / "fleet.zarr")
    assert nw.ensemble(dtc, y=Y, u=U, duration=20.0, store=tmp_path / "fleet.zarr").attrs["complete"] == 1


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
