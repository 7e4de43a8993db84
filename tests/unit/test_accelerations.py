"""Accelerations from the motion: noise in them biases nothing, and what was measured well stays."""

from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from narrows.captive.accelerations import motion_of, with_accelerations

RUNS = (
    *(nw.HarmonicRun(f"{kind}{u}{p}", kind, 0.5, p, u, 3) for kind in ("yaw", "sway") for u in (0.7, 1.0)
      for p in (14.0, 23.0)),
    *(nw.StraightRun(f"straight{y}", y) for y in (1.0, -1.5)),
)  # fmt: skip
RATES = ("udot", "vdot", "rdot")


def noisy_twin(share: float, seed: int = 0, velocities: float = 0.0) -> nw.CaptiveTests:
    """White noise on accelerations, and on the rest of the motion, each over its own size in the table."""
    clean, draw = nw.twin(runs=RUNS, rate=8.0, seed=seed), np.random.default_rng(seed)
    sizes = {name: share * np.sqrt(np.mean(clean.columns[name] ** 2)) for name in RATES}
    sizes |= {name: velocities * clean.columns[name].std() for name in ("y", "psi", "v", "r")}
    noise = {name: size * draw.standard_normal(clean.rows) for name, size in sizes.items()}
    return replace(clean, columns={**clean.columns, **{n: clean.columns[n] + own for n, own in noise.items()}})


@pytest.mark.parametrize("velocities", [0.0, 0.02])
def test_a_tenth_of_noise_biases_neither_mass_nor_bank(dtc: nw.Model, velocities: float) -> None:
    """Means over twins within three standard errors of the truth; as measured, masses are 1 % short for certain."""
    found = {"checked": [], "measured": []}
    for seed in range(10):
        for choice, values in found.items():
            fit = nw.identify(noisy_twin(0.1, seed, velocities), accelerations=choice)
            values.append([fit.least_squares[name] for name in ("b_vdot", "c_rdot", "b_bank")])
    truth = np.array([dtc.coefficients[name] for name in ("b_vdot", "c_rdot", "b_bank")])
    checked, measured = (np.array(found[choice]) / truth for choice in ("checked", "measured"))
    off, error = checked.mean(axis=0) - 1, checked.std(axis=0, ddof=1) / np.sqrt(len(checked))
    assert (np.abs(off) < 3 * error + 5e-4).all()
    assert (measured.mean(axis=0)[:2] < 0.992).all()


def test_what_was_measured_well_stays() -> None:
    clean = nw.twin(runs=RUNS, rate=8.0)
    assert with_accelerations(clean).columns["vdot"] is clean.columns["vdot"]
    assert with_accelerations(clean).notes == clean.notes
    moved = with_accelerations(clean, "motion").columns
    for name in RATES:
        np.testing.assert_allclose(moved[name], clean.columns[name], atol=1e-5)


def test_a_constant_speed_has_no_acceleration() -> None:
    clean = nw.twin(runs=RUNS, rate=8.0)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(clean.rows)
    tests = with_accelerations(replace(clean, columns={**clean.columns, "udot": noise}))
    assert not tests.columns["udot"].any()


def test_steep_paths_hold_more_than_five_harmonics() -> None:
    steep = nw.twin(runs=(nw.HarmonicRun("steep", "yaw", 2.8, 20.0, 1.0, 3),), rate=8.0)
    assert with_accelerations(steep).columns["rdot"] is steep.columns["rdot"]


def test_the_notes_name_what_strays_and_where() -> None:
    noisy = noisy_twin(0.1)
    said = [note for note in nw.identify(noisy).notes if "differs from the motion" in note]
    assert [note.split()[1] for note in said] == ["vdot", "rdot"]
    assert all("taken from the motion" in note for note in said)
    kept = [note for note in nw.identify(noisy, accelerations="measured").notes if "differs from the motion" in note]
    assert all("biases their coefficients towards 0" in note for note in kept)
    with pytest.raises(nw.InputError, match="accelerations = 'none'"):
        nw.identify(noisy, accelerations="none")


def test_one_test_whose_accelerometer_was_off_is_named() -> None:
    clean = nw.twin(runs=RUNS, rate=8.0)
    vdot = clean.columns["vdot"].copy()
    vdot[clean.starts[5] : clean.starts[6]] *= 1.2
    wrong = replace(clean, columns={**clean.columns, "vdot": vdot})
    (said,) = (note for note in nw.identify(wrong).notes if "differs from the motion" in note)
    assert f"in test {RUNS[5].name}:" in said
    np.testing.assert_allclose(with_accelerations(wrong).columns["vdot"], clean.columns["vdot"], atol=1e-6)


def test_ramps_keep_what_was_measured() -> None:
    t = np.arange(0, 40, 0.1)
    run = {"t": t, "y": 0 * t, "psi": 0 * t, "u": 0.5 + 0.02 * t, "v": 0 * t, "r": 0 * t}
    assert set(motion_of(run, 4.0).harmonics) == {"v", "r"}


@pytest.mark.parametrize("period", [7.3, 20.0, 61.0])
@pytest.mark.parametrize("cycles", [1, 2.4, 6])
def test_period(period: float, cycles: float) -> None:
    t = np.arange(0, cycles * period, 0.25)
    draw = np.random.default_rng(1)
    y = 0.3 + 0.5 * np.sin(2 * np.pi * t / period + 0.7) + 0.005 * draw.standard_normal(len(t))
    still = np.zeros(len(t))
    found = motion_of({"t": t, "y": y, "psi": still, "u": still + 1, "v": np.gradient(y, t), "r": still}, 4.0)
    assert 2 * np.pi / found.frequency == pytest.approx(period, rel=0.01)


def test_tests_without_rows_are_passed_over() -> None:
    clean = nw.twin(runs=RUNS[:3], rate=8.0)
    rows = int(clean.starts[1])
    starts = np.concatenate([[0], clean.starts[1:] - rows])
    rest = nw.CaptiveTests({n: c[rows:] for n, c in clean.columns.items()}, clean.names, starts, clean.configuration)
    for choice in ("checked", "motion", "measured"):
        assert with_accelerations(rest, choice).rows == rest.rows
