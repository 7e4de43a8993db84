"""More kinds of twins: what changes within a run or from one type of runs to another, and forces of another origin."""

import numpy as np
from trust_tank import (
    BANK,
    CONFIGURATION,
    DOZEN,
    FULL,
    HARMONIC,
    HULL,
    NONE,
    RATE,
    Columns,
    Kind,
    Tank,
    delta,
    forces,
    law,
    measured,
    steady,
    straight,
    sway,
    yaw,
)

import narrows as nw

Record = dict[str, np.ndarray]
FOUR = [straight(y) for y in (1.1, -1.1, 1.7, -1.7)]


def settling(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Forces that begin a share s too high and settle over 5 s in every run."""

    def spoil(_: np.random.Generator, i: int, record: Record) -> Record:
        high = 1 + s * np.exp(-np.arange(len(record["u"])) / RATE / 5)
        return {**record, **{f: record[f] * high for f in "XYN"}}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


def gain_of_straight_runs(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Forces of four straight runs without drift read too large by a share s; four harmonic runs are correct."""

    def spoil(_: np.random.Generator, i: int, record: Record) -> Record:
        return {**record, **{f: record[f] * (1 + s * steady(record)) for f in "XYN"}}

    runs = [yaw(0.9, 28), yaw(0.6, 20), sway(0.5, 16), sway(0.4, 20), *FOUR]
    return measured(rng, runs, law(), Tank(gain=0.01, spoil=spoil)), BANK


def rail_of_straight_runs(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """In straight runs the ship is s [m] nearer to the wall than recorded, as on a mount that yields."""

    def truth(run: Columns) -> Columns:
        return forces({**run, "y": run["y"] + s * np.sign(run["y"]) * steady(run)}, BANK)

    return measured(rng, FULL, truth, Tank(gain=0.01)), BANK


def batches(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Two batches of runs, in random order; the second reads more by a share s, and the truth is the mean."""
    second = set(rng.permutation(len(FULL))[: len(FULL) // 2].tolist())

    def spoil(_: np.random.Generator, i: int, record: Record) -> Record:
        return {**record, **{f: record[f] * (1 + s * (i in second)) for f in "XYN"}}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), {k: v * (1 + s / 2) for k, v in BANK.items()}


def power_of_y(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; a force that goes as y to the power s, at 1.7 m a third of what the usual bank's would be."""
    there = {"y": np.array([1.7]), "u": np.array([1.0]), "cos_psi": np.array([1.0])}

    def truth(run: Columns) -> Columns:
        grown = np.sign(run["y"]) * (np.abs(run["y"]) / 1.7) ** s
        return forces(run, BANK, felt=delta(there)[0] / 3 * grown * run["u"] ** 2)

    return measured(rng, DOZEN, truth, Tank(gain=0.01)), NONE


def hull_with_memory(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; a share s of the lift comes 3 s late, as from a wake."""
    from scipy.signal import lfilter

    keep = np.exp(-1 / (RATE * 3.0))

    def late(x: np.ndarray) -> np.ndarray:
        return np.asarray(lfilter([1 - keep], [1, -keep], x, zi=[x[0] * keep])[0]) - x

    def truth(run: Columns) -> Columns:
        plain, v, r = forces(run, NONE), late(run["v"]), late(run["r"])
        lift = {"Y": HULL["b_v"] * v + HULL["b_r"] * r, "N": HULL["c_v"] * v + HULL["c_r"] * r}
        return {**plain, **{force: plain[force] - s * more for force, more in lift.items()}}

    return measured(rng, FULL, truth, Tank(gain=0.01)), NONE


def lift_by_yaw_rate(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; lift that grows by a share s at a yaw rate of 0.1 rad/s, and drift to the side the ship is on."""
    drifting = [straight(q * y, q * b) for y, b in ((1.1, 3), (1.7, 6)) for q in (-1, 1)]

    def truth(run: Columns) -> Columns:
        return forces(run, NONE, lift=1 + s * np.abs(run["r"]) / 0.1)  # type: ignore[arg-type]

    return measured(rng, [*HARMONIC, *drifting, straight(0, 5)], truth, Tank(gain=0.01)), NONE


def drift_to_one_side(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; drift to starboard alone, where the ship is to starboard, and a side force of s [N] in these runs."""
    drifting = [straight(y, b) for y, b in ((0.6, 3), (1.1, 5), (1.5, 8))]

    def truth(run: Columns) -> Columns:
        plain = forces(run, NONE)
        return {**plain, **{force: plain[force] + s * steady(run) for force in "YN"}}

    return measured(rng, [*HARMONIC, *drifting, straight(1.1)], truth, Tank(gain=0.01)), NONE


def narrower_canal(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Walls that slope: at the ship's draft the canal is s [m] narrower than written; the truth is the slope amidst."""
    ship, width = CONFIGURATION.ship, CONFIGURATION.canal.width - s

    def felt(run: Columns) -> np.ndarray:
        starboard, port = ((width / 2 + q * run["y"]) / run["cos_psi"] for q in (-1, 1))
        pressure = (starboard / (starboard - ship.beam / 2)) ** 2 - (port / (port - ship.beam / 2)) ** 2
        size = 0.5 * 1000.0 * ship.block_coefficient * ship.length * ship.draft
        return np.asarray(size * run["u"] ** 2 * pressure)

    amidst = {"y": np.array([0.02]), "u": np.array([1.0]), "cos_psi": np.array([1.0])}
    ratio = float(felt(amidst)[0] / delta(amidst)[0])
    tests = measured(rng, FULL, lambda run: forces(run, BANK, felt=felt(run)), Tank(gain=0.01))
    return tests, {name: value * ratio for name, value in BANK.items()}


def heel(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; the ship heels with Y, which adds a moment of s N m that goes as Y squared, at 50 N."""

    def truth(run: Columns) -> Columns:
        plain = forces(run, NONE)
        return {**plain, "N": plain["N"] + s * plain["Y"] * np.abs(plain["Y"]) / 2500}

    return measured(rng, FULL, truth, Tank(gain=0.01)), NONE


def clipped(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Gauges that read to a share s of the largest force and no farther."""
    tests = measured(rng, FULL, law(), Tank(gain=0.005))
    most = {f: s * np.abs(tests.columns[f]).max() for f in "YN"}
    columns = {**tests.columns, **{f: np.clip(tests.columns[f], -m, m) for f, m in most.items()}}
    return nw.CaptiveTests(columns, tests.names, tests.starts, tests.configuration), BANK


TYPES_OF_RUNS: dict[Kind, tuple[float, ...]] = {
    settling: (0.1, 0.3, 1.0), gain_of_straight_runs: (0.05, 0.1, 0.2), rail_of_straight_runs: (0.02, 0.05, 0.2),
    batches: (0.03, 0.1, 0.2), power_of_y: (1.5, 2.0), hull_with_memory: (0.2, 1.0), lift_by_yaw_rate: (0.3, 1.0),
    drift_to_one_side: (1.0, 4.0), narrower_canal: (0.3, 1.0), heel: (5.0, 50.0), clipped: (0.9, 0.5),
}  # fmt: skip
"""The kinds, each with its strengths from faint to gross."""
