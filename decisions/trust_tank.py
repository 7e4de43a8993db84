"""A ship, a tank and forces of twins that break assumptions: how runs are made and measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

import narrows as nw
from narrows.captive.synthetic import Run

CONFIGURATION = nw.Configuration(nw.Ship(5.0, 0.75, 0.25, 0.7), nw.Canal(9.0, 0.5))
RATE, SIZE = 8.0, {"X": 0.4, "Y": 0.8, "N": 1.2}
"""Of sampling [Hz], and noise [N, N, N m], correlated over 0.3 s."""
HULL = {
    "a_uu": 25.0, "b_vdot": 1500.0, "b_rdot": -120.0, "b_v": 220.0, "b_r": 260.0, "b_vv": 6000.0, "b_rr": -300.0,
    "c_vdot": -120.0, "c_rdot": 2100.0, "c_v": 1000.0, "c_r": 400.0, "c_vv": 1500.0, "c_rr": 9000.0,
}  # fmt: skip
BANK, NONE = {"b_bank": 0.7, "c_bank": 0.1}, {"b_bank": 0.0, "c_bank": 0.0}
Columns = Mapping[str, np.ndarray]
Law = Callable[[Columns], Columns]
Kind = Callable[[np.random.Generator, float], tuple[nw.CaptiveTests, dict[str, float]]]


def yaw(amplitude: float, period: float, speed: float = 1.1, offset: float = 0.0, cycles: int = 2) -> nw.HarmonicRun:
    """Make a harmonic yaw run."""
    name = f"yaw {amplitude} m {period} s {speed} m/s at {offset} m x {cycles}"
    return nw.HarmonicRun(name, "yaw", amplitude, period, speed, cycles, offset)


def sway(amplitude: float, period: float, speed: float = 1.1, offset: float = 0.0, cycles: int = 2) -> nw.HarmonicRun:
    """Make a harmonic sway run."""
    name = f"sway {amplitude} m {period} s {speed} m/s at {offset} m x {cycles}"
    return nw.HarmonicRun(name, "sway", amplitude, period, speed, cycles, offset)


def straight(y: float, drift: float = 0.0, speed: float = 1.1) -> nw.StraightRun:
    """Make a straight run; drift in degrees."""
    return nw.StraightRun(f"straight {y} m {drift} deg {speed} m/s", y, speed, 30.0, float(np.radians(drift)))


SWAYS = [sway(0.5, 16), sway(0.35, 11)]
HARMONIC = [yaw(1.0, 28), yaw(0.6, 28), yaw(0.5, 17), yaw(0.8, 17), *SWAYS]
SIDES = [straight(y, b) for y, b in ((1.1, 0), (-1.1, 0), (1.7, 0), (-1.7, 0), (1.4, 4), (-1.4, -4), (0.3, 6))]
FULL = [*HARMONIC, yaw(0.9, 22), sway(0.4, 20), *SIDES]
DOZEN = [*HARMONIC, yaw(0.9, 22), sway(0.4, 20), yaw(0.4, 22), yaw(0.7, 20), sway(0.6, 16), sway(0.25, 11), *SIDES]
"""What separates the bank: a dozen harmonic runs at several periods, seven straight ones to both sides."""


def delta(run: Columns) -> np.ndarray:
    """Return the form of the published bank term over the half breadths of force, u squared and all."""
    ship, width = CONFIGURATION.ship, CONFIGURATION.canal.width
    starboard, port = (width / 2 - run["y"]) / run["cos_psi"], (width / 2 + run["y"]) / run["cos_psi"]
    pressure = (starboard / (starboard - ship.beam / 2)) ** 2 - (port / (port - ship.beam / 2)) ** 2
    return np.asarray(0.5 * 1000.0 * ship.block_coefficient * ship.length * ship.draft * run["u"] ** 2 * pressure)


def forces(
    run: Columns,
    bank: Mapping[str, float],
    hull: Mapping[str, float] = HULL,
    lift: float = 1.0,
    felt: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """Forces of terms like the published ones; ``lift`` scales what is linear in v and r."""
    u, v, r, vdot, rdot = (run[name] for name in ("u", "v", "r", "vdot", "rdot"))
    pressure = delta(run) if felt is None else felt
    length = CONFIGURATION.ship.length
    across, turn = -np.abs(v) * v, -np.abs(r) * r
    return {
        "X": -hull["a_uu"] * u * np.abs(u),
        "Y": -hull["b_vdot"] * vdot - hull["b_rdot"] * rdot - lift * (hull["b_v"] * v + hull["b_r"] * r)
        + hull["b_vv"] * across + hull["b_rr"] * turn + bank["b_bank"] * pressure,
        "N": -hull["c_vdot"] * vdot - hull["c_rdot"] * rdot - lift * (hull["c_v"] * v + hull["c_r"] * r)
        + hull["c_vv"] * across + hull["c_rr"] * turn - bank["c_bank"] * pressure * length,
    }  # fmt: skip


def noise(rng: np.random.Generator, rows: int, time: float = 0.3) -> np.ndarray:
    """Return noise of unit size that is correlated over a time [s]."""
    from scipy.signal import lfilter

    keep = np.exp(-1 / (RATE * time))
    gain = np.sqrt(1 - keep**2)
    white = rng.standard_normal(rows)
    return np.asarray(lfilter([gain], [1, -keep], white, zi=[(1 - gain) * white[0]])[0])


@dataclass(frozen=True)
class Tank:
    """How runs are made and measured.

    Every error is drawn for each run; ``form`` for each motion, shared by its repeats.
    """

    gain: float = 0.0
    zero: float = 0.0
    form: float = 0.0
    spikes: float = 0.0
    wander: float = 0.0
    time: float = 0.3
    repeats: Mapping[int, int] = field(default_factory=dict)
    spoil: Callable[[np.random.Generator, int, dict[str, np.ndarray]], dict[str, np.ndarray]] | None = None
    """Last of all: what is done to the record of a run, by its number."""


def measured(
    rng: np.random.Generator,
    runs: Sequence[Run],
    law: Callable[[Columns], Columns],
    tank: Tank = Tank(),
    depth: float = 0.5,
) -> nw.CaptiveTests:
    """Make runs and measure them."""
    parts, names = [], []
    for i, run in enumerate(runs):
        columns = run.columns(RATE)
        motion = {**columns, "cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
        rows = len(columns["t"])
        motion["depth"] = np.full(rows, run.depth or depth)
        clean = law(motion)
        shape = {force: _shape(rng, rows, tank.form * np.sqrt(np.mean(value**2))) for force, value in clean.items()}
        for k in range(tank.repeats.get(i, 1)):
            record = {**motion, **{f: _record(rng, value, shape[f], SIZE[f], tank) for f, value in clean.items()}}
            parts.append(tank.spoil(rng, i, record) if tank.spoil else record)
            names.append(f"{run.name} #{k}")
    starts = np.concatenate([[0], np.cumsum([len(part["t"]) for part in parts])])
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return nw.CaptiveTests(columns, tuple(names), starts, CONFIGURATION)


def _shape(rng: np.random.Generator, rows: int, size: float) -> np.ndarray:
    wave = 2 * np.pi * rng.integers(1, 4) * np.arange(rows) / rows * 2
    return np.asarray(size * rng.standard_normal() * np.cos(wave + 2 * np.pi * rng.random()))


def _record(rng: np.random.Generator, clean: np.ndarray, shape: np.ndarray, size: float, tank: Tank) -> np.ndarray:
    rows = len(clean)
    rough = noise(rng, rows, tank.time) + 20 * (rng.random(rows) < tank.spikes) * rng.standard_normal(rows)
    slow = tank.wander * noise(rng, rows, 20.0)
    return np.asarray(
        clean * (1 + tank.gain * rng.standard_normal())
        + shape
        + tank.zero * rng.standard_normal()
        + size * (rough + slow)
    )


def law(bank: Mapping[str, float] = BANK, **options: object) -> Law:
    """Return the forces of a bank."""
    return lambda run: forces(run, bank, **options)  # type: ignore[arg-type]


def joined(*parts: nw.CaptiveTests) -> nw.CaptiveTests:
    """Put tests together."""
    lengths = np.concatenate([np.diff(part.starts) for part in parts])
    return nw.CaptiveTests(
        {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns},
        tuple(f"{i} {name}" for i, part in enumerate(parts) for name in part.names),
        np.concatenate([[0], np.cumsum(lengths)]), CONFIGURATION,
    )  # fmt: skip


def octaves(run: Columns) -> float:
    """How many octaves the period of a harmonic run is over 16 s; 0 of a steady one."""
    moving = run["v"] if np.ptp(run["v"]) > np.ptp(run["r"]) else run["r"]
    rate = run["vdot"] if np.ptp(run["v"]) > np.ptp(run["r"]) else run["rdot"]
    return 0.0 if np.ptp(run["y"]) < 1e-9 else float(np.log2(2 * np.pi * moving.std() / rate.std() / 16))


def steady(run: Columns) -> bool:
    """Whether nothing oscillates."""
    return bool(np.ptp(run["y"]) < 1e-9)


@dataclass(frozen=True)
class Drifted:
    """A harmonic run with a drift angle."""

    run: nw.HarmonicRun
    drift: float

    name = property(lambda self: f"{self.run.name} drift {self.drift}")
    depth = property(lambda self: self.run.depth)

    def columns(self, rate: float) -> dict[str, np.ndarray]:
        own, b = self.run.columns(rate), np.radians(self.drift)
        return own | {"v": own["v"] - own["u"] * np.sin(b), "u": own["u"] * np.cos(b), "psi": own["psi"] + b}
