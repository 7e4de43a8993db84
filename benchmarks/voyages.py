"""Voyages to the grounding: ours beside SciPy, heyoka, diffrax and shipmmg, in one run.

    python benchmarks/voyages.py [VESSELS] [--small]

Every engine but shipmmg sails the paper's model from the same starts until a hull corner meets a bank; shipmmg has no
bank, so that its row is its own KT model, a step of its output at a time. PythonVehicleSimulator is not on the package
index and is left out. Rounds of all of them are interleaved, and the medians are of process time, which other work on
the machine disturbs least; it counts the threads of diffrax together.
"""

import math
from collections.abc import Callable

import numpy as np
from common import installed, interleaved, median_seconds, show, sizes
from scipy.integrate import solve_ivp

import narrows as nw

MODEL = nw.published("mikkelsen2025_dtc")
VALUES = MODEL.coefficients
STARTS = np.random.default_rng(0).uniform(0.3, 2.6, 65_536)
LENGTH, BEAM, WIDTH = 3.984, 0.572, 7.0
BANK = 0.5 * 0.661 * 1000.0 * LENGTH * 0.163
INVERSE = np.linalg.inv([[VALUES["b_vdot"], VALUES["b_rdot"]], [VALUES["c_vdot"], VALUES["c_rdot"]]]).tolist()
DAMPING = tuple(tuple(VALUES[f"{force}_{name}"] for name in ("v", "r", "vv", "rr")) for force in "bc")
ALONG = VALUES["b_bank"] * BANK, -VALUES["c_bank"] * BANK * LENGTH
FAR, DT = 60.0, 0.02


def fleet(vessels: int, **options: object) -> None:
    """Ours, to a located contact."""
    nw.ensemble(MODEL, y=np.resize(STARTS, vessels), duration=FAR, dt=DT, **options)


def with_scipy(vessels: int) -> None:
    """DOP853 with an event, on the paper's equations in plain Python."""

    def rates(_, z):
        return symbolic(math.cos, math.sin, abs, *z)[0]

    def gap(_, z):
        return symbolic(math.cos, math.sin, abs, *z)[1]

    gap.terminal = True
    for y in STARTS[:vessels].tolist():
        solve_ivp(rates, (0.0, FAR), (y, 0.0, 0.0, 0.0), "DOP853", events=gap, rtol=1e-10, atol=1e-12)


def symbolic(cos, sin, size, y, psi, v, r):
    """The paper's equations for engines that bring their own symbols: rates of y, psi, v, r, and the gap."""
    starboard, port = (WIDTH / 2 - y) / cos(psi), (WIDTH / 2 + y) / cos(psi)
    delta = (starboard / (starboard - BEAM / 2)) ** 2 - (port / (port - BEAM / 2)) ** 2
    Y, N = (
        b * delta - k_v * v - k_r * r - k_vv * size(v) * v - k_rr * size(r) * r
        for b, (k_v, k_r, k_vv, k_rr) in zip(ALONG, DAMPING, strict=True)
    )
    vdot, rdot = (m_sway * Y + m_yaw * N for m_sway, m_yaw in INVERSE)
    gap = WIDTH / 2 - size(y) - LENGTH / 2 * size(sin(psi)) - BEAM / 2 * cos(psi)
    return (sin(psi) + v * cos(psi), r, vdot, rdot), gap


def with_heyoka(vessels: int):
    """Taylor's method of heyoka with a terminal event."""
    import heyoka as hy

    y, psi, v, r = hy.make_vars("y", "psi", "v", "r")
    rates, gap = symbolic(hy.cos, hy.sin, lambda z: hy.sqrt(z * z + 1e-30), y, psi, v, r)
    system = list(zip((y, psi, v, r), rates, strict=True))
    engine = hy.taylor_adaptive(system, [0.0] * 4, t_events=[hy.t_event(gap)])

    def sail() -> None:
        for start in STARTS[:vessels]:
            engine.time, engine.state[:] = 0.0, (start, 0.0, 0.0, 0.0)
            engine.reset_cooldowns()
            engine.propagate_until(FAR)

    return sail


def with_diffrax(vessels: int):
    """Dopri8 of diffrax, all vessels at once, with an event and its root finder."""
    import diffrax as dfx
    import jax
    import jax.numpy as jnp
    import optimistix as optx

    jax.config.update("jax_enable_x64", True)

    def parts(z):
        return symbolic(jnp.cos, jnp.sin, jnp.abs, *z)

    term = dfx.ODETerm(lambda t, z, _: jnp.stack(parts(z)[0]))
    event = dfx.Event(lambda t, y, args, **_: parts(y)[1], optx.Newton(1e-8, 1e-8))

    def one(start):
        return dfx.diffeqsolve(
            term, dfx.Dopri8(), 0.0, FAR, 0.1, jnp.stack([start, 0.0, 0.0, 0.0]), event=event, throw=False,
            stepsize_controller=dfx.PIDController(rtol=1e-8, atol=1e-10), max_steps=4096,
        ).ys  # fmt: skip

    run = jax.jit(jax.vmap(one))
    starts = jnp.asarray(STARTS[:vessels])
    return lambda: run(starts).block_until_ready()


def with_shipmmg(steps: int) -> None:
    """The KT model of shipmmg by its own solver."""
    from shipmmg.kt import simulate

    simulate(0.155, 80.5, np.linspace(0, 100, steps), np.full(steps, 0.1))


def main(many: int, small: bool) -> None:
    """Measure and print."""
    few, alone = (20, 2) if small else (2000, 20)
    works: dict[str, Callable[[], object]] = {
        "narrows": lambda: fleet(many, workers=1),
    }
    peers = (("heyoka", with_heyoka), ("diffrax", with_diffrax))
    works |= {name: make(few) for name, make in peers if installed(name)}
    works["SciPy DOP853"] = lambda: with_scipy(alone)
    counts = {"narrows": many, "SciPy DOP853": alone}
    rows = [(name, taken / counts.get(name, few), "") for name, taken in interleaved(works, 2 if small else 7).items()]
    show("one vessel to a located grounding, process time", rows, "us", 1e6)
    if installed("shipmmg"):
        steps = median_seconds(lambda: with_shipmmg(2000), 3) / 2000
        print(f"shipmmg, its KT model without banks: {steps * 1e6:.2g} us an output step")
    sizes_of_fleets = {100: 3, 10_000: 3} | ({} if small else {1_000_000: 3, 10_000_000: 1})
    costs = [
        (f"{n:.0e} vessels", median_seconds(lambda n=n: fleet(n), k) / n, "all cores")
        for n, k in sizes_of_fleets.items()
    ]
    show("cost against the size of the fleet, a vessel, by the clock", costs, "us", 1e6)


if __name__ == "__main__":
    main(*sizes(__doc__, usual=65_536, small=1024))
