"""The exported header beside the package: the same lines, by another compiler."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compiled import COMPILER, FLAGS, CompiledShip, needs_compiler
from exported import STEERED, TABLES, bent, model_of, speed_of, states

import narrows as nw
from narrows.simulation.initial_state import POSE, initial_state
from narrows.simulation.ship import SimulatedShip, steering_of
from narrows.waterway.bank_clearance import exact_clearance

pytestmark = needs_compiler
PUSH = {"Y": 0.7, "N": -0.4}
IN_WATERWAY = ("paper+keel_gap", "steered", "mmg+delta")
KINDS = {0: "afloat", 1: "grounded", 2: "diverged", 3: "outside", 5: "passed"}


def surge_of(name: str) -> str:
    return "free" if name == "mmg+delta" else "held"


@pytest.fixture(scope="module")
def ships(tmp_path_factory: pytest.TempPathFactory) -> Any:
    made: dict[tuple[str, bool, str], CompiledShip] = {}

    def ship(name: str, curved: bool = False, contact: Any = "corners") -> CompiledShip:
        key = (name, curved, str(contact))
        if key not in made:
            folder = tmp_path_factory.mktemp("ship")
            waterway = bent(name) if curved else None
            choices = {"waterway": waterway, "surge": surge_of(name), "contact": contact}
            made[key] = CompiledShip(model_of(name), folder, **choices)
        return made[key]

    return ship


def close(one: Any, other: Any, most: float) -> None:
    one, other = np.asarray(one), np.asarray(other)
    assert np.abs(one - other).max() <= most * max(1.0, np.abs(other).max())


@pytest.mark.parametrize("name", TABLES)
def test_rates_and_derivatives_are_those_of_python(ships: Any, name: str) -> None:
    ship, model = ships(name), model_of(name)
    ship.set(Y_in=0.7, N_in=-0.4)
    linear = SimulatedShip(model, surge_of(name)).linearisation(SimulatedShip(model, surge_of(name)).values())
    revolutions = {"revolutions": model.configuration.propeller.revolutions} if name == "mmg+delta" else {}
    for state in states(name, 8):
        x, y, cosine, sine, u, v, r, *rudder = state
        psi = np.arctan2(sine, cosine)
        positions = dict(zip(("rudder",), rudder, strict=False)) | revolutions
        expected = nw.derivative(model, [x, y, psi, u, v, r], **PUSH, surge=surge_of(name), **positions)
        rates = ship.called("rates", state, 7)
        close(rates[[0, 1, 4, 5, 6]], expected[[0, 1, 3, 4, 5]], 1e-12)
        close(cosine * rates[3] - sine * rates[2], expected[2], 1e-12)
        at = {
            "y": y,
            "cos_psi": cosine,
            "sin_psi": sine,
            "u": u,
            "v": v,
            "r": r,
            "Y_in": 0.7,
            "N_in": -0.4,
            **positions,
        }
        hull = model.configuration.ship
        reach = hull.length / 2 * abs(sine) + hull.beam / 2 * cosine
        half = model.configuration.canal.width / 2
        close(ship.called("clearance", state, 2), [half - y - reach, half + y - reach], 1e-12)
        by_state, by_input = np.hsplit(linear.linear(at), [6])
        close(ship.called("by_state", state, 36), by_state.ravel(), 1e-12)
        close(ship.called("by_input", state, by_input.size), by_input.ravel(), 1e-12)
        by_coefficient = linear.coefficients(at)[3:]
        close(ship.called("by_coefficient", state, by_coefficient.size), by_coefficient.ravel(), 1e-12)


@pytest.mark.parametrize("name", IN_WATERWAY)
def test_steps_and_derivatives_in_a_waterway(ships: Any, name: str) -> None:
    """Steps against Python's; derivatives against differences of the rates, the section's slope in them."""
    ship, model = ships(name, True), model_of(name)
    rudder = 0.1 if name in STEERED else 0.0
    ship.set(**({"rudder_order": rudder} if name in STEERED else {}))
    simulated = SimulatedShip(model, surge_of(name))
    steering = steering_of(nw.ConstantRudder(rudder), simulated.actuators) if name in STEERED else None
    for state in states(name, 5):
        x, y, cosine, sine, u, v, r, *_ = state
        start = {"x": x, "y": y, "psi": np.arctan2(sine, cosine), "u": u, "v": v, "r": r, "rudder": 0.0}
        integrator, begun = initial_state(simulated, steering, start, bent(name), False)
        after, clearance, side = integrator.stepped(begun, 0.05)
        close(ship.called("step", begun, len(begun) + 2, 0.05), [*after, clearance, side], 1e-12)
        starboard, port = ship.called("clearance", begun, 2)
        water, step = integrator.channel, 1 / integrator.inputs["cells_a_metre"]
        nearer, leaning = exact_clearance(water.track.tolist(), step, *begun[:4], water.outline.tolist())
        close([min(starboard, port), port - starboard], [nearer, leaning], 1e-12)
        by_state = ship.called("by_state", begun, 36).reshape(6, 6)
        close(by_state, np.stack([slope(ship, begun, column) for column in range(6)], axis=1), 2e-6)


@pytest.mark.parametrize(("name", "curved"), [("paper", False), ("mmg+delta", False), ("steered", True)])
def test_a_block_is_its_ships(ships: Any, name: str, curved: bool) -> None:
    """Every second one with half the inputs; to the bit without a rudder, whose sine is a polynomial there."""
    ship, at = ships(name, curved), states(name, 64)
    ship.set(Y_in=0.7, N_in=-0.4, **({"rudder_order": 0.2} if name in STEERED else {}))
    inputs = dict(zip(ship.names, ship.inputs.copy(), strict=True))
    block = ship.called("block", at.ravel(), 64 * (at.shape[1] + 2), 0.05).reshape(64, -1)
    for lane, state in enumerate(at):
        ship.set(**{one: value * (0.5 if lane % 2 else 1.0) for one, value in inputs.items()})
        alone = ship.called("step", state, len(state) + 2, 0.05)
        np.testing.assert_allclose(block[lane], alone, rtol=1e-13 if name in STEERED else 0, atol=1e-15)


def slope(ship: CompiledShip, state: Any, column: int, h: float = 1e-6) -> np.ndarray:
    """Of the rates of x, y, psi, u, v, r, by a central difference."""

    def rates(by: float) -> np.ndarray:
        moved = np.array(state)
        psi = np.arctan2(moved[3], moved[2]) + (by if column == 2 else 0.0)
        moved[2], moved[3] = np.cos(psi), np.sin(psi)
        if column != 2:
            moved[column if column < 2 else column + 1] += by
        xdot, ydot, cosine, sine, *rest = ship.called("rates", moved, 7)
        return np.array([xdot, ydot, moved[2] * sine - moved[3] * cosine, *rest])

    return (rates(h) - rates(-h)) / (2 * h)


@pytest.mark.parametrize(("name", "curved"), [("paper", False), ("steered", True), ("mmg+delta", False)])
def test_voyages_end_where_those_of_python_do(ships: Any, name: str, curved: bool) -> None:
    voyages_agree(ships(name, curved), name, bent(name) if curved else None, "corners")


OUTLINE = [(2.0, 0.0), (1.4, 0.3), (-1.9, 0.3), (-1.9, -0.3), (1.4, -0.3)]


@pytest.mark.parametrize(
    ("name", "contact"), [("paper", "midship"), ("paper", OUTLINE), ("steered", OUTLINE)],
    ids=["midship", "outline", "outline in a waterway"],
)  # fmt: skip
def test_hulls_of_other_shapes(ships: Any, name: str, contact: Any) -> None:
    water = bent(name) if name == "steered" else None
    # At midship the suction ends infinite, and the velocities with it: there the pose is what can be held.
    voyages_agree(ships(name, bool(water), contact), name, water, contact, 3 if contact == "midship" else 6)


def voyages_agree(ship: CompiledShip, name: str, waterway: Any, contact: Any, held: int = 6) -> None:
    model, u, size = model_of(name), speed_of(name), model_of(name).configuration.ship.length / 4
    ends = set()
    for y, psi, order in ((0.5, 0.02, 0.1), (-0.7, 0.01, -0.2), (0.0, -0.03, 0.02)):
        start = {"x": 3.0 * size, "y": y * size, "psi": psi, "u": u, "v": 0.01, "r": 0.002}
        told = {"controller": nw.ConstantRudder(order)} if name in STEERED else {}
        voyage = nw.simulate(
            model, **start, duration=40.01, dt=0.05, surge=surge_of(name), waterway=waterway, contact=contact,
            bottom=False, **told,
        )  # fmt: skip
        ship.set(**({"rudder_order": order} if told else {}))
        state = [start["x"], start["y"], np.cos(psi), np.sin(psi), u, 0.01, 0.002, *([0.0] if told else [])]
        outcome, time, _, end = ship.integrate(state, 0.05, 40.01)
        ends.add(outcome)
        assert KINDS[outcome] == {"time_up": "afloat"}.get(voyage.outcome.kind, voyage.outcome.kind)
        close(time, voyage.outcome.time, 1e-10)
        reached = [end[0], end[1], np.arctan2(end[3], end[2]), *end[4:7]]
        close(reached[:held], [voyage.outcome.state[one] for one in POSE[:held]], 1e-10)
    assert 1 in ends


def test_written_again_it_is_the_same_to_the_byte(tmp_path: Path) -> None:
    """Also by another process, that orders sets otherwise."""
    nw.export.write(model_of("steered"), tmp_path / "ship.h")
    nw.save_model(model_of("steered"), tmp_path / "model.toml")
    order = "import narrows as nw; nw.export.write(nw.load_model('model.toml'), 'again/ship.h')"
    (tmp_path / "again").mkdir()
    subprocess.run([sys.executable, "-c", order], cwd=tmp_path, check=True, env=other_seed())
    assert (tmp_path / "ship.h").read_bytes() == (tmp_path / "again" / "ship.h").read_bytes()


def other_seed() -> dict[str, str]:
    return {**os.environ, "PYTHONHASHSEED": "7"}


def test_the_program_of_the_docs_says_what_python_says(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "export.md").read_text(encoding="utf-8")
    model = nw.published("mikkelsen2025_dtc")
    nw.export.write(model, tmp_path / "dtc.h")
    said = printed(page.split("```c\n")[1].split("```")[0], tmp_path)
    outcome = nw.simulate(model, y=0.5, u=1.0).outcome
    assert said == f"aground to {outcome.side} after {outcome.time:.2f} s and {outcome.state['x']:.2f} m\n"
    short = page.split("```c\n")[1].split("```")[0].replace("time < 60.0", "time < 2.0")
    assert printed(short, tmp_path).startswith("afloat after 2.00 s and ")


def printed(program: str, folder: Path) -> str:
    """Output of a program beside its header, compiled with the warnings of the optimiser too."""
    (folder / "main.c").write_text(program, encoding="utf-8")
    subprocess.run([COMPILER, *FLAGS, "-O2", "main.c", "-o", "main", "-lm"], cwd=folder, check=True)
    return subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler is here")
@pytest.mark.parametrize("curved", [False, True])
def test_the_header_is_cpp_too(tmp_path: Path, curved: bool) -> None:
    nw.export.write(model_of("steered"), tmp_path / "ship.h", waterway=bent("steered") if curved else None)
    flags = ["-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-x", "c++"]
    (tmp_path / "main.cpp").write_text('#include "ship.h"\nint main() { return 0; }\n', encoding="utf-8")
    subprocess.run(["g++", *flags, "main.cpp"], cwd=tmp_path, check=True)


CLASS = """#include <cstdio>
#include "tanker.hpp"
#include "dtc.hpp"
int main() {
    tanker::Ship ship;
    ship.x(6.0), ship.y(0.5), ship.psi(0.02), ship.u(%(u)r), ship.inputs.rudder_order = 0.1;
    const bool aground = ship.integrate(0.05, 60.0) == tanker::Outcome::Grounded;
    std::printf("%%d %%.17g %%.17g %%.17g %%.17g %%.17g %%.17g\\n", aground, ship.time, ship.x(), ship.y(), ship.psi(),
                ship.rudder(), ship.side);
    dtc::Ship other;
    other.u(1.0), other.step(0.05);
    std::printf("%%.17g %%.17g %%d\\n", other.clearance()[0], other.rates()[0], other.beyond());
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler is here")
@pytest.mark.parametrize("curved", [False, True])
def test_the_class_of_cpp_sails_the_voyage(tmp_path: Path, curved: bool) -> None:
    """Two ships in one program, without a warning."""
    model, way = model_of("steered"), bent("steered") if curved else None
    nw.export.write(model, tmp_path / "tanker.hpp", waterway=way)
    nw.export.write(nw.published("mikkelsen2025_dtc"), tmp_path / "dtc.hpp")
    u = speed_of("steered")
    (tmp_path / "main.cpp").write_text(CLASS % {"u": u}, encoding="utf-8")
    strict = ["-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"]
    subprocess.run(["g++", *strict, "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    first, second = subprocess.run(
        ["./main"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    voyage = nw.simulate(
        model, x=6.0, y=0.5, psi=0.02, u=u, dt=0.05, waterway=way, controller=nw.ConstantRudder(0.1)
    ).outcome
    aground, time, x, y, psi, rudder, side = map(float, first.split())
    assert aground == 1
    assert [time, x, y, psi] == pytest.approx(
        [voyage.time, *[voyage.state[name] for name in ("x", "y", "psi")]], rel=1e-10
    )
    assert (side > 0) == (voyage.side == "starboard")
    assert abs(rudder) <= 0.1
    clearance, ahead, _ = map(float, second.split())
    ship = nw.published("mikkelsen2025_dtc").configuration
    assert clearance == pytest.approx((ship.canal.width - ship.ship.beam) / 2, rel=1e-12)
    assert ahead == pytest.approx(1.0)


VESSEL = """#include <cstdio>
#include "vessel.hpp"
int main() {
    Vessel vessel(-0.3, 1.0);
    vessel.order_rudder(-0.1);
    for (int tick = 0; tick < 40; ++tick) {
        vessel.advance(0.1, 0.05);
        const Motion m = vessel.motion();
        std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g\\n", m.x, m.y, m.yaw, m.u, m.v, m.r,
                    vessel.port() - vessel.starboard());
    }
    while (vessel.advance(0.1, 0.05)) { }
    std::printf("%g\\n", vessel.motion().u);
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler is here")
def test_the_vessel_of_the_ros_example_has_the_axes_of_ros(tmp_path: Path) -> None:
    """REP 103: y to port and angles counter-clockwise, so that a voyage of Python is its mirror image."""
    folder = Path(__file__).parents[2] / "examples" / "ros2"
    nw.export.write(model_of("steered"), tmp_path / "ship.hpp")
    (tmp_path / "main.cpp").write_text(VESSEL, encoding="utf-8")
    shutil.copy(folder / "src" / "vessel.hpp", tmp_path)
    strict = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"]
    subprocess.run(["g++", *strict, "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    *rows, last = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout.split(
        "\n"
    )[:-1]
    voyage = nw.simulate(
        model_of("steered"), y=0.3, u=1.0, dt=0.05, duration=4.0, controller=nw.ConstantRudder(0.1)
    ).to_dataframe()[2::2]
    expected = np.stack([voyage.x, -voyage.y, -voyage.psi, voyage.u, -voyage.v, -voyage.r], axis=1)
    said = np.array([row.split() for row in rows], float)
    np.testing.assert_allclose(said[:, :6], expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(said[:, 6], 2 * voyage.y, rtol=1e-9)
    assert float(last) == 0.0, "it lies still at the bank"
    dependencies = set(re.findall(r"<depend>(\w+)", (folder / "package.xml").read_text()))
    found = set(re.findall(r"find_package\((\w+)", (folder / "CMakeLists.txt").read_text()))
    included = set(re.findall(r"#include <(\w+)/", (folder / "src" / "ship_node.cpp").read_text()))
    assert dependencies == included == found - {"ament_cmake"}


def test_the_file_names_what_is_in_it(tmp_path: Path) -> None:
    nw.export.write(model_of("paper"), tmp_path / "4 dtc-model.h")
    text = (tmp_path / "4 dtc-model.h").read_text(encoding="utf-8")
    assert "static inline void ship_4_dtc_model_step(" in text
    assert subprocess.run([COMPILER, *FLAGS, "-x", "c", "-fsyntax-only", tmp_path / "4 dtc-model.h"]).returncode == 0


def test_a_name_cannot_end_its_comment(tmp_path: Path) -> None:
    model = model_of("paper")
    ship = replace(model.configuration.ship, name="*/ int main(void) { return 1; } /*\\")
    nw.export.write(replace(model, configuration=replace(model.configuration, ship=ship)), tmp_path / "ship.h")
    assert "*/ int" not in (tmp_path / "ship.h").read_text(encoding="utf-8")
    subprocess.run([COMPILER, *FLAGS, "-x", "c", "-fsyntax-only", tmp_path / "ship.h"], check=True)


def test_refusals_write_nothing(tmp_path: Path) -> None:
    with pytest.raises(nw.InputError, match=r"\.h"):
        nw.export.write(model_of("paper"), tmp_path / "ship.txt")
    with pytest.raises(nw.InputError, match="inertia"):
        nw.export.write(nw.published("mikkelsen2025_dtc"), tmp_path / "ship.h", surge="free")
    assert list(tmp_path.iterdir()) == []
