"""Voyages to the grounding: ours beside SciPy, heyoka, diffrax and shipmmg, in one run.

    python benchmarks/voyages.py

Every engine but shipmmg sails the paper's model from the same starts until a hull corner meets a bank; shipmmg has no
bank, so that its row is its own KT model, a step of its output at a time. PythonVehicleSimulator is not on the package
index and is left out.
"""

import importlib.util

import numpy as np
from common import median_seconds, show

import narrows as nw
from narrows.simulation.integrate import dop853
from narrows.simulation.ship import SimulatedShip

MODEL = nw.published("mikkelsen2025_dtc")
SHIP = SimulatedShip(MODEL)
STARTS = np.random.default_rng(0).uniform(0.3, 2.6, 65_536)
LENGTH, BEAM, WIDTH = 3.984, 0.572, 7.0
FAR, DT = 60.0, 0.02


def fleet(vessels: int, **options: object) -> None:
    """Ours, to a located contact."""
    nw.ensemble(MODEL, y=np.resize(STARTS, vessels), duration=FAR, dt=DT, **options)


def with_scipy(vessels: int) -> None:
    """DOP853 with an event, on our right-hand side in plain Python."""
    rhs, room, tail = SHIP.program.rhs, SHIP.program.gap, (0.0, 0.0, 0.0, *SHIP.controls(0.0), *SHIP.constants)
    for y in STARTS[:vessels]:
        start = (0.0, float(y), 1.0, 0.0, 1.0, 0.0, 0.0)
        list(dop853(lambda z: rhs(*z, *tail), start, [0.0, FAR], lambda z: room(*z[1:4], *SHIP.constants), DT))


def symbolic(cos, sin, size, y, psi, v, r):
    """The paper's equations for engines that bring their own symbols: rates of y, psi, v, r, and the gap."""
    a = MODEL.coefficients
    bank = 0.5 * 0.661 * 1000.0 * LENGTH * 0.163
    starboard, port = (WIDTH / 2 - y) / cos(psi), (WIDTH / 2 + y) / cos(psi)
    delta = (starboard / (starboard - BEAM / 2)) ** 2 - (port / (port - BEAM / 2)) ** 2
    sway, yaw = (
        -a[f"{c}_v"] * v - a[f"{c}_r"] * r - a[f"{c}_vv"] * size(v) * v - a[f"{c}_rr"] * size(r) * r for c in "bc"
    )
    inverse = np.linalg.inv([[a["b_vdot"], a["b_rdot"]], [a["c_vdot"], a["c_rdot"]]])
    forces = sway + a["b_bank"] * bank * delta, yaw - a["c_bank"] * bank * LENGTH * delta
    vdot, rdot = (float(row[0]) * forces[0] + float(row[1]) * forces[1] for row in inverse)
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


def main() -> None:
    """Measure and print."""
    many, rows = 65_536, []
    for name, options in {
        "narrows, one core": {"workers": 1},
        "narrows, all cores": {},
        "narrows, one core, float32": {"workers": 1, "precision": "float32"},
    }.items():
        rows.append((name, median_seconds(lambda o=options: fleet(many, **o), 5) / many, ""))
    for name, module, few, make in (
        ("heyoka, one core", "heyoka", 2000, with_heyoka),
        ("diffrax", "diffrax", 2000, with_diffrax),
    ):
        if importlib.util.find_spec(module):
            rows.append((name, median_seconds(make(few), 3) / few, ""))
    rows.append(("SciPy DOP853, one core", median_seconds(lambda: with_scipy(20), 3) / 20, "our right-hand side"))
    show("one vessel to a located grounding", rows, "us", 1e6)
    if importlib.util.find_spec("shipmmg"):
        steps = median_seconds(lambda: with_shipmmg(2000), 3) / 2000
        print(f"shipmmg, its KT model without banks: {steps * 1e6:.2g} us an output step")
    counts = {100: 3, 10_000: 3, 1_000_000: 3, 10_000_000: 1}
    sizes = [(f"{n:.0e} vessels", median_seconds(lambda n=n: fleet(n), k) / n, "all cores") for n, k in counts.items()]
    show("cost against the size of the fleet, a vessel", sizes, "us", 1e6)


if __name__ == "__main__":
    main()
