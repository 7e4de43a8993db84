"""The fleets of a page beside the package's kernel and voyages: by plain JavaScript, by WebAssembly where zig is."""

from pathlib import Path

import numpy as np
import pytest
from exported import model_of
from opened_pages import answer, fleet_ends, needs_node, needs_zig, on_page, wasm_here

import narrows as nw
from narrows.export.page.assembly import bundled, helm_of
from narrows.simulation.grid import _within
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import KernelRun

pytestmark = needs_node
SHIPS, STEPS = 4000, 1300
METRES = {"plain": 1e-9, "double": 1e-9, "single": 2e-4}


def starts_of(states: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Ships all over the canal, at many speeds, each with a step of its own."""
    ship = np.arange(SHIPS)
    y, u = -2 + 4 * (ship + 0.5) / SHIPS, 0.4 + (ship * 7 % 100) / 100
    starts = np.zeros((SHIPS, states + 1))
    starts[:, 1], starts[:, 2], starts[:, 4], starts[:, -1] = y, 1.0, u, 0.02 / u
    return starts, {"y": y, "u": u, "dt": 0.02 / u}


@pytest.mark.parametrize(
    "kind", ["plain", pytest.param("double", marks=needs_zig), pytest.param("single", marks=needs_zig)]
)
def test_ships_end_where_those_of_the_kernel_do(kind: str, tmp_path: Path) -> None:
    model = nw.published("mikkelsen2025_dtc")
    exported, wasm = on_page(model, 1.0), None
    if kind != "plain":
        wasm = tmp_path / "fleet.wasm"
        wasm.write_bytes(wasm_here(exported, kind == "single"))
    starts, chosen = starts_of(7)
    ends = fleet_ends(exported, starts, STEPS, wasm)
    values = {**START, "X": 0.0, "Y": 0.0, "N": 0.0, "y": chosen["y"], "u": chosen["u"]}
    run = KernelRun(exported.ship, STEPS * chosen["dt"], chosen["dt"])
    expected = run.run({**values, **model.configuration.values(), **model.coefficients}, SHIPS)
    assert np.array_equal(ends[:, -1], expected["outcome"])
    aground = expected["outcome"] == 1
    assert np.array_equal(np.sign(ends[aground, 1]), expected["side"][aground])
    assert np.abs(ends[:, 0] - expected["distance"]).max() < METRES[kind]
    assert np.abs(ends[:, 1] - expected["y_end"]).max() < METRES[kind]
    assert 0.5 < aground.mean() < 1.0


@pytest.mark.parametrize("kind", ["plain", pytest.param("double", marks=needs_zig)])
def test_a_helm_steers_as_it_does_in_a_voyage(kind: str, tmp_path: Path) -> None:
    model = model_of("steered")
    exported, wasm = on_page(model, 1.0), None
    if kind != "plain":
        wasm = tmp_path / "fleet.wasm"
        wasm.write_bytes(wasm_here(exported))
    helm = helm_of(model, 1.0)[0]
    assert helm is not None
    for steers in (True, False):
        starts = np.zeros((2, len(exported.kept) + 1))
        starts[:, 1], starts[:, 2], starts[:, 4], starts[:, -1] = [0.5, -1.1], 1.0, 0.9, 0.02
        starts[:, [7, -2]] = 0.0 if steers else 0.05  # The rudder, and what the helm ordered last.
        told = {"law_steers": 1.0 if steers else -1.0, "law_ordered": 0.05}
        for row, end in zip(starts, fleet_ends(exported, starts, 1000, wasm, **told), strict=True):
            controller = helm.law if steers else nw.ConstantRudder(0.05)
            start = {"y": row[1], "u": 0.9, "rudder": row[7]}
            outcome = nw.simulate(model, **start, duration=20.0, dt=0.02, controller=controller).outcome
            assert outcome.kind == {0: "afloat", 1: "grounded", 3: "outside"}[int(end[-1])]
            # The helm is asked once more within the step that ends a voyage: for the shorter step.
            assert np.abs(end[:2] - [outcome.state["x"], outcome.state["y"]]).max() < 1e-5


@needs_zig
def test_roots_and_odd_powers_are_those_of_the_library(tmp_path: Path) -> None:
    """By a table of one's own that asks for both: WebAssembly has no C library to call."""
    exported, wasm = on_page(model_of("own"), 1.0), tmp_path / "fleet.wasm"
    wasm.write_bytes(wasm_here(exported))
    starts = starts_of(7)[0][::100]
    plain, ends = (fleet_ends(exported, starts, 500, path) for path in (None, wasm))
    assert np.array_equal(ends[:, -1], plain[:, -1])
    assert np.abs(ends[:, :2] - plain[:, :2]).max() < 1e-9


def test_percentages_of_a_fleet_add_up_to_100() -> None:
    script = f"""{bundled("outcome.js", {}, set())}
import {{ readFileSync }} from "fs";
const told = JSON.parse(readFileSync(0, "utf8")).map((counts) => module_outcome.shares(counts, 3000));
console.log(JSON.stringify(told));
"""
    asked = [[646, 1255, 1099, 0], [3000, 0, 0, 0], [2999, 1, 0, 0], [1000, 1000, 1000, 0]]
    said = [[share.replace("\u00a0%", "") for share in shares] for shares in answer(script, asked)]
    assert said[0][:3] == ["21", "42", "37"], "each rounded would add up to 101"
    assert said[1][0] == "all"
    assert said[2][:2] == ["over 99", "under 1"]
    assert said[3][:3] == ["34", "33", "33"]


def test_coefficients_are_drawn_as_in_python() -> None:
    """The same normal numbers give the same coefficients, brought back to their bounds together."""
    draw = np.random.default_rng(4)
    half = draw.normal(size=(5, 5))
    mean, low, high = draw.normal(size=5), np.full(5, -np.inf), np.array([0.1, np.inf, 0.2, np.inf, np.inf])
    share, axes = np.linalg.eigh(half @ half.T)
    root = (axes * np.sqrt(share)) @ axes.T
    normals = draw.normal(size=(40, 5))
    expected = _within(mean + normals @ root, root @ root, low, high)
    script = f"""{bundled("draws.js", {}, set())}
import {{ readFileSync }} from "fs";
const {{ root, bounds, mean, normals }} = JSON.parse(readFileSync(0, "utf8"));
const draw = module_draws.drawing(root, bounds);
console.log(JSON.stringify(normals.map((normal) => draw(mean, normal))));
"""
    bounds = [[None, float(top) if np.isfinite(top) else None] for top in high]
    asked = {"root": root.tolist(), "bounds": bounds, "mean": mean.tolist(), "normals": normals.tolist()}
    assert np.abs(np.array(answer(script, asked)) - expected).max() < 1e-12
