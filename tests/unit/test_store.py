"""Ensembles on disk: the same answer, resumed after a stop, and on a cluster whose worker is killed."""

import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

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
    same(stored, nw.ensemble(dtc, y=Y, u=U, duration=20.0))


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
