"""Synthetic tests move as a rig would move them: velocities and accelerations are the derivatives of the path."""

import numpy as np
import pytest

import narrows as nw

RUNS = (nw.HarmonicRun("yaw", "yaw", 1.2, 14.0, 0.9, 2), nw.HarmonicRun("sway", "sway", 0.8, 11.0, 0.7, 2))
RATE = 200.0


@pytest.fixture(scope="module", params=["yaw", "sway"])
def run(request: pytest.FixtureRequest) -> dict[str, np.ndarray]:
    return nw.twin(runs=RUNS, rate=RATE, noise={}).test(request.param)


def derivative(column: np.ndarray) -> np.ndarray:
    """Central differences of fourth order, two rows short at each end."""
    c = column
    return (c[:-4] - 8 * c[1:-3] + 8 * c[3:-1] - c[4:]) * RATE / 12


@pytest.mark.parametrize(("position", "rate"), [("psi", "r"), ("r", "rdot"), ("v", "vdot"), ("u", "udot")])
def test_rates(run: dict[str, np.ndarray], position: str, rate: str) -> None:
    np.testing.assert_allclose(derivative(run[position]), run[rate][2:-2], atol=1e-7)


def test_path(run: dict[str, np.ndarray]) -> None:
    """North and east from surge, sway and heading."""
    north = run["u"] * np.cos(run["psi"]) - run["v"] * np.sin(run["psi"])
    east = run["u"] * np.sin(run["psi"]) + run["v"] * np.cos(run["psi"])
    np.testing.assert_allclose(derivative(run["y"]), east[2:-2], atol=1e-7)
    np.testing.assert_allclose(derivative(run["x"]), north[2:-2], atol=1e-4)


def test_each_kind_moves_as_its_name_says() -> None:
    tests = nw.twin(runs=RUNS, rate=RATE, noise={})
    yaw, sway = tests.test("yaw"), tests.test("sway")
    assert not yaw["v"].any()
    assert not sway["r"].any()
    assert not sway["psi"].any()
    for run, own in zip(RUNS, (yaw, sway), strict=True):
        assert np.abs(own["y"]).max() == pytest.approx(run.amplitude, rel=1e-4)
        assert len(own["t"]) == run.cycles * run.period * RATE
        np.testing.assert_array_equal(own["u"], run.speed)


@pytest.mark.parametrize("time", [0.0, 1.0])
def test_noise_has_its_size_and_its_memory(time: float) -> None:
    """A first-order autoregression: correlation exp(-lag / time), and everywhere the stated standard deviation."""
    runs = (nw.HarmonicRun("long", "sway", 0.8, 11.0, 0.7, 300),)
    quiet, noisy = (nw.twin(runs=runs, noise=n, correlation_time=time, seed=3) for n in ({}, {"X": 2.0}))
    noise = noisy.columns["X"] - quiet.columns["X"]
    np.testing.assert_array_equal(noisy.columns["Y"], quiet.columns["Y"])
    assert noise.std() == pytest.approx(2.0, rel=0.06)
    for lag in (1, 20):
        expected = np.exp(-lag / (20 * time)) if time else 0.0
        assert np.corrcoef(noise[lag:], noise[:-lag])[0, 1] == pytest.approx(expected, abs=0.06)


def test_correlated_noise_begins_as_large_as_it_goes_on() -> None:
    run = (nw.HarmonicRun("short", "sway", 0.8, 11.0, 0.7, 1),)
    quiet = nw.twin(runs=run, rate=2.0, noise={}).columns["Y"]
    noisy = [
        nw.twin(runs=run, rate=2.0, noise={"Y": 1.0}, correlation_time=5.0, seed=s).columns["Y"] for s in range(400)
    ]
    spread = np.std(np.array(noisy) - quiet, axis=0)
    np.testing.assert_allclose(spread, 1.0, atol=0.15)


def test_seed_makes_the_noise() -> None:
    one, same, other = (nw.twin(runs=RUNS, seed=seed).columns["Y"] for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)
