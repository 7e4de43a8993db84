"""Kinds of twins that break assumptions of identification, each from faint to gross; no truth is of the fitted terms.

Another ship and tank than any measured one. A kind takes a random generator and a strength, and gives tests with the
truth of the bank's coefficients; the strengths that are tried stand beside it in ``KINDS``.
"""

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
    SWAYS,
    Columns,
    Drifted,
    Kind,
    Tank,
    delta,
    forces,
    joined,
    law,
    measured,
    octaves,
    steady,
    straight,
    sway,
    yaw,
)
from trust_types_of_runs import TYPES_OF_RUNS

import narrows as nw

# ------------------------------------------------------------ what differs from run to run


def honest(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A plan that separates, gains that scatter by s, zeros of 0.5 N."""
    return measured(rng, DOZEN, law(), Tank(gain=s, zero=0.5 * (s > 0))), BANK


def gain(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Gains that scatter by s from run to run."""
    return measured(rng, FULL, law(), Tank(gain=s)), BANK


def zero(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Zeros that scatter by s [N, N m]."""
    return measured(rng, FULL, law(), Tank(zero=s)), BANK


def form(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A form error of every motion, two motions made twelve times."""
    return measured(rng, FULL, law(), Tank(form=s, repeats={1: 12, 9: 12})), BANK


def repeats(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; as in the KCS tests most runs are one motion, with a form error; the rest cannot part bank and hull."""
    runs = [yaw(1.0, 28), yaw(0.6, 28), yaw(0.8, 28, 0.8), *SWAYS]
    return measured(rng, runs, law(NONE), Tank(form=s, gain=0.01, repeats={0: 14})), NONE


def near_repeats(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; ten straight runs side by side that share an error of place of s [N]."""
    place = s * rng.standard_normal(3)

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return (
            record if i < len(HARMONIC) else {**record, **{f: record[f] + e for f, e in zip("XYN", place, strict=True)}}
        )

    runs = [*HARMONIC, *(straight(round(1.0 + 0.05 * i, 2)) for i in range(10))]
    return measured(rng, runs, law(NONE), Tank(gain=0.01, spoil=spoil)), NONE


def unequal(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Two runs ten times as long, a form error in every motion."""
    runs = [yaw(1.0, 28, cycles=20), sway(0.5, 16, cycles=20), *FULL[1:4], *FULL[5:]]
    return measured(rng, runs, law(), Tank(form=s)), BANK


def few_tests(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """The first s runs of a plan in random order, 3 % gain."""
    chosen = [FULL[i] for i in rng.permutation(len(FULL))[: int(s)]]
    return measured(rng, chosen, law(), Tank(gain=0.03)), BANK


def outliers(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A share s of rows twenty sigma out, zeros that wander within a run, 2 % gain."""
    return measured(rng, FULL, law(), Tank(gain=0.02, spikes=s, wander=2.0)), BANK


def bad_run(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """One run whose forces are all off by a share s."""
    bad = int(rng.integers(len(FULL)))

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, **{f: record[f] * (1 + s * (i == bad)) for f in "XYN"}}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


def zero_of_a_day(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; the straight runs, all to one side, were made on a day with a zero of its own."""
    day = s * rng.standard_normal(3)

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, **{f: record[f] + e * (i >= len(HARMONIC)) for f, e in zip("XYN", day, strict=True)}}

    return measured(
        rng, [*HARMONIC, *(straight(y) for y in (0.9, 1.3, 1.8))], law(NONE), Tank(gain=0.01, spoil=spoil)
    ), NONE


def gain_of_a_day(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Gains that drift by a share s through the campaign, the straight runs last."""

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, **{f: record[f] * (1 + s * (i / len(FULL) - 0.5)) for f in "XYN"}}

    return measured(rng, FULL, law(), Tank(gain=0.005, spoil=spoil)), BANK


def wandering_zero(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Noise that is correlated over 20 s, s times the usual."""
    return measured(rng, FULL, law(), Tank(wander=s)), BANK


def gain_by_kind(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Straight runs read more than harmonic ones by a share s."""

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, **{f: record[f] * (1 + s * steady(record)) for f in "XYN"}}

    return measured(rng, DOZEN, law(), Tank(gain=0.01, spoil=spoil)), BANK


# ------------------------------------------------------------ a hull that is not of the terms


def hull_by_speed(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; lift that grows as u to the power s, speeds so close that neighbours chain."""
    speeds = (0.8, 0.9, 1.0, 1.1)
    runs = [yaw(a, 26, u) for u in speeds for a in (0.5, 0.9)] + [sway(0.5, 15, u) for u in speeds]
    return measured(rng, runs, lambda run: forces(run, NONE, lift=float(run["u"].mean()) ** s), Tank(gain=0.005)), NONE


def hull_by_speed_one_straight(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """The same at three speeds with one straight run, which is 20 s long."""
    runs = [yaw(a, 26, u) for u in (0.7, 1.0, 1.3) for a in (0.5, 0.9)] + [sway(0.5, 15, u) for u in (0.7, 1.0, 1.3)]
    runs.append(nw.StraightRun("one", 1.2, 1.0, 20.0))
    return measured(rng, runs, lambda run: forces(run, NONE, lift=float(run["u"].mean()) ** s), Tank(gain=0.005)), NONE


def hull_by_period(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; damping and lift that change by s an octave of the period, five periods, no straight runs."""
    runs = [yaw(a, p) for p in (16, 20, 25, 32, 40) for a in (0.5, 0.9)] + [sway(0.5, p) for p in (11, 16, 24)]
    return measured(rng, runs, lambda run: forces(run, NONE, lift=1 + s * octaves(run))), NONE


def hull_by_period_and_straight(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A bank, a hull that changes by s an octave, and straight runs that part the two."""
    return measured(rng, DOZEN, lambda run: forces(run, BANK, lift=1 + s * octaves(run)), Tank(gain=0.01)), BANK


def inertia_by_period(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; added masses that change by s an octave, lift by speed."""
    runs = [yaw(a, 28, u) for u in (1.1, 0.75) for a in (0.9, 0.6)] + [sway(0.5, 16), sway(0.35, 11), sway(0.4, 22)]

    def truth(run: Columns) -> Columns:
        hull = {**HULL, **{k: HULL[k] * (1 + s * octaves(run)) for k in ("b_vdot", "c_rdot")}}
        return forces(run, NONE, hull, lift=float(run["u"].mean()) * (1 + 2 * s * octaves(run)))

    return measured(rng, runs, truth, Tank(gain=0.005)), NONE


def hull_by_depth(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; a hull that grows as the water shallows, three depths, fitted with a bank that knows the depth."""
    parts = []
    for depth, grown in ((0.5, 1.0), (0.375, 1 + s / 3), (0.3, 1 + s)):
        hull = {name: value * grown for name, value in HULL.items()}
        runs = [yaw(1.0, 28), yaw(0.6, 28), yaw(0.5, 17), *SWAYS]
        parts.append(measured(rng, runs, law(NONE, hull=hull), Tank(gain=0.01), depth))
    return joined(*parts), NONE


def static_unlike_harmonic(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; static drift forces are 1 + s times the harmonic ones, and the ship drifts to the side it is on."""
    runs = [*HARMONIC, *(straight(q * y, q * b) for y, b in ((0.8, 4), (1.3, 6), (1.7, 8)) for q in (-1, 1))]
    return measured(rng, runs, lambda run: forces(run, NONE, lift=1 + s * steady(run)), Tank(gain=0.01)), NONE


def crossflow(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; mixed terms of crossflow of size s in the truth, drift and yaw combined."""
    drifting = [Drifted(yaw(0.7, p), 5.0) for p in (24, 18)]
    runs = [*HARMONIC, *(straight(y, b) for y, b in ((0.6, 3), (-0.6, -3), (1.2, 6), (-1.2, -6))), *drifting]

    def truth(run: Columns) -> Columns:
        own, v, r = forces(run, NONE), run["v"], run["r"]
        mixed = 9000.0 * s
        return {**own, "Y": own["Y"] - mixed * np.abs(r) * v, "N": own["N"] - mixed * np.abs(v) * r}

    return measured(rng, runs, truth), NONE


def cubic_hull(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Damping partly cubic in v and r, a share s of the quadratic damping; with a bank."""

    def truth(run: Columns) -> Columns:
        own, v, r = forces(run, BANK), run["v"], run["r"]
        return {**own, "Y": own["Y"] - s * 4e4 * v**3, "N": own["N"] - s * 2e5 * r**3}

    return measured(rng, FULL, truth, Tank(gain=0.01)), BANK


def asymmetric_hull(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; a side force of s N at 1 m/s that goes with the square of the speed; straight runs to one side."""
    runs = [
        *HARMONIC,
        yaw(0.9, 28, 0.8),
        *(straight(y, 0, u) for y, u in ((0.9, 1.1), (1.3, 1.1), (1.7, 1.1), (1.3, 0.8))),
    ]

    def truth(run: Columns) -> Columns:
        own = forces(run, NONE)
        return {**own, "Y": own["Y"] + s * run["u"] ** 2, "N": own["N"] - s * run["u"] ** 2}

    return measured(rng, runs, truth, Tank(gain=0.01)), NONE


def blockage(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Lift that grows by a share s towards the walls; a bank."""

    def truth(run: Columns) -> Columns:
        return forces(run, BANK, lift=1 + s * (run["y"] / 2) ** 2)  # type: ignore[arg-type]

    return measured(rng, FULL, truth, Tank(gain=0.01)), BANK


def drift_couples(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; lift that grows by a share s towards the walls, and straight runs that drift to the side they are on."""
    drifting = [straight(q * y, q * b) for y, b in ((0.8, 3), (1.3, 5), (1.8, 7)) for q in (-1, 1)]

    def truth(run: Columns) -> Columns:
        return forces(run, NONE, lift=1 + s * (run["y"] / 2) ** 2)  # type: ignore[arg-type]

    return measured(rng, [*HARMONIC, *drifting, straight(0, 4), straight(0, -6)], truth, Tank(gain=0.01)), NONE


def cubic_y(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """No bank; a force that goes as the cube of y, at 1.7 m s times what the usual bank's would be."""
    there = {"y": np.array([1.7]), "u": np.array([1.0]), "cos_psi": np.array([1.0])}

    def truth(run: Columns) -> Columns:
        return forces(run, BANK, felt=s * delta(there)[0] * (run["y"] / 1.7) ** 3 * run["u"] ** 2)

    return measured(rng, DOZEN, truth, Tank(gain=0.01)), NONE


def memory(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Forces that reach the record s seconds late."""

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, **{f: np.roll(record[f], round(s * RATE)) for f in "XYN"}}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


# ------------------------------------------------------------ a bank that is not of the terms


def tapered(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A bank that weakens by a share s close to both walls, several runs there."""
    runs = [*FULL, *(straight(side * y) for y in (2.8, 3.1, 3.3) for side in (-1, 1))]

    def truth(run: Columns) -> Columns:
        weak = 1 - s * (0.5 + 0.5 * np.tanh(3 * (np.abs(run["y"]) - 2.9)))
        return forces(run, BANK, felt=delta(run) * weak)

    return measured(rng, runs, truth, Tank(gain=0.005)), BANK


def other_form(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A share s of the bank's force goes as one over the distance; the truth is the slope at the centreline."""
    runs = [*FULL, straight(3.2), straight(-3.0)]

    def felt(run: Columns) -> np.ndarray:
        half, slope = CONFIGURATION.canal.width / 2, 0.02
        near = 1 / (half - run["y"]) - 1 / (half + run["y"])
        still = {"y": np.array([slope]), "u": np.array([1.0]), "cos_psi": np.array([1.0])}
        scale = delta(still)[0] / (1 / (half - slope) - 1 / (half + slope))
        return np.asarray((1 - s) * delta(run) + s * scale * near * run["u"] ** 2)

    return measured(rng, runs, lambda run: forces(run, BANK, felt=felt(run)), Tank(gain=0.005)), BANK


def bank_by_speed(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A bank that is weaker by a share s at the lower of two speeds; the truth is the mean."""
    slow = [
        *(straight(y, 0, 0.7) for y in (1.1, -1.1, 1.7, -1.7)),
        yaw(0.8, 28, 0.7),
        yaw(0.5, 17, 0.7),
        sway(0.5, 16, 0.7),
    ]

    def truth(run: Columns) -> Columns:
        return forces(run, BANK, felt=delta(run) * (1 - s * (run["u"].mean() < 0.9)))

    return measured(rng, [*FULL, *slow], truth, Tank(gain=0.01)), {k: v * (1 - s / 2) for k, v in BANK.items()}


def bank_by_period(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A bank force that is larger by a share s in harmonic runs than in steady ones; the truth is the steady one."""
    return measured(
        rng, FULL, lambda run: forces(run, BANK, felt=delta(run) * (1 + s * (not steady(run)))), Tank(gain=0.01)
    ), BANK


def one_sided_bank(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A bank that is weaker by a share s to starboard; the truth is the mean of both sides."""

    def truth(run: Columns) -> Columns:
        return forces(run, BANK, felt=delta(run) * (1 - s * (run["y"] > 0)))

    return measured(rng, FULL, truth, Tank(gain=0.01)), {k: v * (1 - s / 2) for k, v in BANK.items()}


def faint_bank(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A bank of s times the usual."""
    bank = {k: v * s for k, v in BANK.items()}
    return measured(rng, FULL, law(bank), Tank(gain=0.01)), bank


# ------------------------------------------------------------ a motion that is not as written


def rail(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """The rail's y is s [m] off in every run."""

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, "y": record["y"] + s}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


def rail_of_a_run(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """The rail's y is off by s [m] from run to run."""

    def spoil(draw: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, "y": record["y"] + s * draw.standard_normal()}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


def heading(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """The ship stands s degrees askew in every run, and v is written without."""

    def askew(run: Columns) -> Columns:
        return forces({**run, "v": run["v"] - run["u"] * np.sin(np.radians(s))}, BANK)

    return measured(rng, FULL, askew, Tank(gain=0.01)), BANK


def heading_of_a_run(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """The ship stands askew by s degrees from run to run, and v is written without."""

    def askew(run: Columns) -> Columns:
        return forces({**run, "v": run["v"] - run["u"] * np.sin(np.radians(s * rng.standard_normal()))}, BANK)

    return measured(rng, FULL, askew, Tank(gain=0.01)), BANK


def speed_of_a_run(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """The carriage's speed is off by a share s from run to run."""

    def spoil(draw: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, "u": record["u"] * (1 + s * draw.standard_normal())}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


def accelerations(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Noise of a share s of their root mean square on the accelerations."""

    def spoil(draw: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        rough = {
            q: record[q] + s * record[q].std() * draw.standard_normal(len(record[q])) for q in ("udot", "vdot", "rdot")
        }
        return {**record, **rough}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


def motion_noise(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """Noise on every quantity of the motion, s times the usual."""
    size = {"y": 0.01, "psi": 0.003, "u": 0.01, "v": 0.005, "r": 0.002, "udot": 0.005, "vdot": 0.01, "rdot": 0.003}

    def spoil(draw: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        own = {q: record[q] + s * e * draw.standard_normal(len(record["t"])) for q, e in size.items()}
        return {**record, **own, "cos_psi": np.cos(own["psi"]), "sin_psi": np.sin(own["psi"])}

    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), BANK


def crosstalk(rng: np.random.Generator, s: float) -> tuple[nw.CaptiveTests, dict[str, float]]:
    """A share s of Y, a metre off, shows in N, and of N in Y; the truth has it in: a calibration of all runs."""

    def spoil(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, "Y": record["Y"] + s * record["N"], "N": record["N"] + s * record["Y"]}

    length = CONFIGURATION.ship.length
    truth = {
        "b_bank": BANK["b_bank"] - s * BANK["c_bank"] * length,
        "c_bank": BANK["c_bank"] - s * BANK["b_bank"] / length,
    }
    return measured(rng, FULL, law(), Tank(gain=0.01, spoil=spoil)), truth


KINDS: dict[Kind, tuple[float, ...]] = {
    honest: (0.0, 0.02), gain: (0.01, 0.03, 0.08), zero: (0.5, 2.0, 6.0), form: (0.02, 0.05, 0.12),
    repeats: (0.02, 0.1), near_repeats: (1.0, 5.0), unequal: (0.01, 0.03, 0.08), few_tests: (3, 5, 8, 12),
    outliers: (0.003, 0.02), bad_run: (0.05, 0.1, 0.2, 0.5), zero_of_a_day: (0.5, 2.0, 8.0),
    gain_of_a_day: (0.03, 0.1, 0.3), gain_by_kind: (0.05, 0.1, 0.2), wandering_zero: (1.0, 4.0),
    hull_by_speed: (0.3, 1.0), hull_by_speed_one_straight: (0.3, 1.0), hull_by_period: (0.05, 0.15, 0.35),
    hull_by_period_and_straight: (0.05, 0.15, 0.35), inertia_by_period: (0.05, 0.15), hull_by_depth: (0.3, 1.2),
    static_unlike_harmonic: (0.05, 0.15, 0.4), crossflow: (0.1, 0.3, 1.0), cubic_hull: (0.1, 0.3, 1.0),
    asymmetric_hull: (0.5, 2.0, 6.0), blockage: (0.1, 0.3, 1.0), drift_couples: (0.3, 1.0),
    cubic_y: (0.1, 0.3, 1.0), memory: (0.125, 0.25),
    tapered: (0.05, 0.15, 0.5), other_form: (0.1, 0.3, 1.0), bank_by_speed: (0.06, 0.2, 0.4),
    bank_by_period: (0.05, 0.15, 0.4), one_sided_bank: (0.1, 0.3, 1.0), faint_bank: (0.1, 0.3),
    rail: (0.05, 0.15), rail_of_a_run: (0.01, 0.05), heading: (0.1, 0.5), heading_of_a_run: (0.05, 0.2),
    speed_of_a_run: (0.005, 0.02), accelerations: (0.03, 0.1), motion_noise: (0.3, 1.0), crosstalk: (0.01, 0.03),
    **TYPES_OF_RUNS,
}  # fmt: skip
"""The kinds, each with its strengths from faint to gross."""
