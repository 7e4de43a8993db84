"""Compiled equations of motion are held to the terms themselves, evaluated by NumPy."""

import pickle
import platform
from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from narrows.compile import LINEARISED, STATE, Program, compiled
from narrows.compile.record import record
from narrows.compile.trace import ACCELERATIONS, trace
from narrows.quantities import dimensions as dim
from narrows.quantities.names import MOTION


def cross_flow(u, v):
    return -u * v


def odd_shapes(y, cos_psi, v, r, width, draft, heave):
    """Roots, odd powers, a number to a power, a reciprocal, a plain + and a NumPy number."""
    bulge = (1.5 + cos_psi) ** 0.5 / (1 + (y / width) ** 2) ** 1.5
    return +bulge * np.float64(0.3) * 2 ** (-abs(v) / 3) * r**5 * (draft + heave) ** -1 - 0.1 * v


OWN = nw.PAPER.with_terms(
    "own",
    surge=[nw.Term("a_vr", "a_{vr}", lambda v, r: v * r, dim.KG)],
    sway=[
        nw.Term("b_uv", "b_{uv}", cross_flow, dim.KG_PER_M),
        nw.Term("b_|odd|", "b_o", odd_shapes, dim.NUMBER, kind=nw.TermKind.BANK),
    ],
)
TABLES = {table.name: table for table in (nw.PAPER, nw.TAPERED, OWN)}
EXTRA = {"a_udot": 20.0, "a_u": 3.0, "a_vr": 40.0, "b_uv": 60.0, "b_|odd|": 900.0}
MASS, SURGE_INERTIA = 245.0, 280.0


def model_of(table: nw.TermTable) -> nw.Model:
    """The published coefficients, with nothing at zero."""
    paper = nw.published("mikkelsen2025_dtc")
    coefficients = {**paper.coefficients, **EXTRA}
    configuration = replace(paper.configuration, ship=replace(paper.configuration.ship, mass=MASS))
    return nw.Model(configuration, table, {name: coefficients[name] for name in table.names})


def values_of(model: nw.Model) -> dict[str, float]:
    return {**model.configuration.values(), **model.coefficients, "surge_inertia": SURGE_INERTIA}


def states(count: int) -> dict[str, np.ndarray]:
    """Random states on both sides, by the names of the equations."""
    draw = np.random.default_rng(1)
    ranges = {"x": 9.0, "y": 2.6, "psi": 1.2, "v": 0.4, "r": 0.3}
    state = {name: draw.uniform(-top, top, count) for name, top in ranges.items()}
    psi = state.pop("psi")
    state |= {"cos_psi": np.cos(psi), "sin_psi": np.sin(psi), "u": draw.uniform(0.3, 1.5, count)}
    return {name: state[name] for name in STATE}


def reference(model: nw.Model, state: dict, pushes: tuple[float, float, float], surge: str, coriolis: bool) -> list:
    """Solve M (udot, vdot, rdot) = f + F_in with the forces that the terms themselves give: floats, one state."""

    def force(**accelerations: float) -> np.ndarray:
        named = {name: value for name, value in state.items() if name in MOTION}
        return np.array(list(model.forces(nw.Motion(**named, **accelerations)).values()), float)

    still = force()
    mass = np.stack([still - force(**{name: 1.0}) for name in ACCELERATIONS.values()], axis=1)
    mass[0, 0] += SURGE_INERTIA
    rest = still + pushes
    if coriolis:
        rest += MASS * state["r"] * np.array([state["v"], -state["u"], 0.0])
    part = slice(0, 3) if surge == "free" else slice(1, 3)
    accelerations = np.zeros(3)
    accelerations[part] = np.linalg.solve(mass[part, part], rest[part])
    u, v, r, c, s = (state[name] for name in ("u", "v", "r", "cos_psi", "sin_psi"))
    return [u * c - v * s, u * s + v * c, -r * s, r * c, *accelerations]


PUSHES = (3.0, -2.0, 5.0)
CONTROLS = (0.995, 0.0999, 2.0)
"""Rudder and propeller, which these tables do not ask for."""


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("surge", ["held", "free"])
@pytest.mark.parametrize("name", TABLES)
def test_plain_form_is_the_terms_own(name: str, surge: str, coriolis: bool) -> None:
    model = model_of(TABLES[name])
    program, columns = compiled(model.terms, surge, coriolis), states(50)
    constants = program.constants(values_of(model))
    together = np.broadcast_arrays(*program.rhs(*columns.values(), *PUSHES, *CONTROLS, *constants))
    for row in range(50):
        state = {key: float(column[row]) for key, column in columns.items()}
        expected = reference(model, state, PUSHES, surge, coriolis)
        alone = program.rhs(*state.values(), *PUSHES, *CONTROLS, *constants)
        np.testing.assert_allclose(alone, expected, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose([column[row] for column in together], expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("name", TABLES)
def test_block_form_is_the_plain_form(name: str) -> None:
    """The right-hand side that kernels step, exponential and roots included; forces are constants there."""
    model, columns = model_of(TABLES[name]), states(40)
    program = compiled(model.terms, "free")
    kernel = program.kernel(varying=False, precision="float64", inputs="constants")
    values = {**values_of(model), "heave": 0.01, **dict(zip(("X_in", "Y_in", "N_in"), PUSHES, strict=True))}
    own = kernel.constants(*(float(values[parameter]) for parameter in kernel.PARAMETERS))
    expected = np.array(
        np.broadcast_arrays(*program.rhs(*columns.values(), *PUSHES, *CONTROLS, *program.constants(values)))
    )
    found = np.array([kernel.rhs(*state, *own) for state in np.array(list(columns.values())).T]).T
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads x86 assembly")
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.slow
def test_a_block_is_stepped_by_vectors(name: str) -> None:
    """No lane on its own: the step divides packed numbers only, and calls no exponential."""
    model = model_of(TABLES[name])
    kernel = compiled(model.terms).kernel(varying=False, precision="float64", inputs="none")
    values = values_of(model) | {"heave": 0.0}
    own = np.array(kernel.constants(*(values[parameter] for parameter in kernel.PARAMETERS)))
    kernel.step(np.zeros(kernel.FIELDS * kernel.LANES), np.ones(5), kernel.uniform(own))
    (assembly,) = kernel.step.inspect_asm().values()
    assert "divpd" in assembly
    assert "divsd" not in assembly


def test_a_replayed_record_is_the_terms_to_the_bit() -> None:
    for table in TABLES.values():
        model = model_of(table)
        inputs = {**model.configuration.values(), **nw.Motion.at(0.3, y=1.1, u=0.9, v=0.1, r=-0.2, rdot=0.4).values()}
        found = record(table).replay(inputs)
        assert found == {term.name: term.column(inputs) for term in table.terms}


def test_records_name_what_is_done_and_nothing_else() -> None:
    renamed = replace(nw.PAPER, name="another name")
    assert record(renamed).text == record(nw.PAPER).text
    texts = {record(table).text for table in TABLES.values()}
    assert len(texts) == len(TABLES)


AT = {"x": 0.0, "y": 1.3, "psi": -0.4, "u": 0.8, "v": 0.11, "r": -0.07}
PUSHED = dict(zip(("X_in", "Y_in", "N_in"), PUSHES, strict=True))
DIFFERENCE = 1e-6


class TestJacobian:
    """Exact derivatives against central differences."""

    def rates(self, program: Program, values: dict, at: dict, inputs: dict) -> np.ndarray:
        y, psi, u, v, r = (at[name] for name in LINEARISED[1:])
        rhs = program.rhs(
            0.0, y, np.cos(psi), np.sin(psi), u, v, r, *inputs.values(), *CONTROLS, *program.constants(values)
        )  # fmt: skip
        return np.array([rhs[0], rhs[1], r, *rhs[4:]])

    def slopes(self, rates, about: dict) -> np.ndarray:
        """Of the rates by each of some named numbers."""
        columns = []
        for name, value in about.items():
            width = DIFFERENCE * max(1.0, abs(value))
            ahead, behind = (rates({**about, name: value + sign * width}) for sign in (1, -1))
            columns.append((ahead - behind) / (2 * width))
        return np.stack(columns, axis=-1)

    @pytest.mark.parametrize("surge", ["held", "free"])
    @pytest.mark.parametrize("name", TABLES)
    def test_derivatives(self, name: str, surge: str) -> None:
        model = model_of(TABLES[name])
        program, values = compiled(model.terms, surge, coriolis=True), values_of(model)
        exact, at = program.jacobian(values), AT
        state = {**at, "cos_psi": np.cos(at["psi"]), "sin_psi": np.sin(at["psi"])}
        found = {kind: getattr(exact, kind)(state, PUSHED) for kind in ("state", "controls", "coefficients")}
        expected = {
            "state": self.slopes(lambda at: self.rates(program, values, at, PUSHED), at),
            "controls": self.slopes(lambda inputs: self.rates(program, values, at, inputs), PUSHED),
            "coefficients": self.slopes(
                lambda own: self.rates(program, values | own, at, PUSHED), dict(model.coefficients)
            ),
        }
        found["controls"] = found["controls"][:, : len(PUSHES)]
        for kind, matrix in expected.items():
            np.testing.assert_allclose(found[kind], matrix, rtol=2e-7, atol=1e-9, err_msg=kind)

    def test_columns_go_through(self) -> None:
        model = model_of(nw.PAPER)
        exact = compiled(nw.PAPER).jacobian(values_of(model))
        columns = states(6)
        many = exact.state(columns)
        assert many.shape == (6, 6, 6)
        for row in range(6):
            one = exact.state({name: column[row] for name, column in columns.items()})
            np.testing.assert_allclose(many[row], one, rtol=1e-13, atol=1e-15)

    def test_of_an_exactly_straight_course(self) -> None:
        """|v| v has no kink in its slope: no sign of zero is asked for, and the published poles come out."""
        model = nw.published("mikkelsen2025_dtc")
        exact = compiled(nw.PAPER).jacobian(values_of(model))
        matrix = exact.state({"cos_psi": 1.0, "u": 1.0})
        poles = np.linalg.eigvals(matrix[np.ix_((1, 2, 4, 5), (1, 2, 4, 5))])
        pair = poles[np.argmax(poles.imag)]
        assert pair == pytest.approx(0.260 + 0.248j, abs=1e-3)


@pytest.mark.parametrize(
    ("regressor", "deed"),
    [
        (lambda v: v if v > 0 else 0.0, "compares"),
        (lambda v: 1.0 if v else 0.0, "branches"),
        (lambda v: max(v, 0.0), "compares"),
        (lambda v: __import__("math").sin(v), "plain number"),
        (lambda v: np.sin(v), "ufunc"),
        (lambda v: v * np.ones(3), "ndarray"),
        (lambda v: v // 2, "rounds"),
        (lambda v: v * 1j, "complex"),
        (lambda v: v * float("inf"), "inf"),
        (lambda v: [v], "list"),
        (lambda v: 1 / 0, "division by zero"),
    ],
)
def test_what_is_not_arithmetic_is_refused(regressor, deed: str) -> None:
    table = nw.PAPER.with_terms("bad", sway=[nw.Term("b_bad", "b", regressor, dim.NUMBER)])
    with pytest.raises(nw.InputError, match=rf"term b_bad: .*{deed}.* arithmetic and abs\(\) alone"):
        compiled(table).constants({})


def test_accelerations_enter_linearly() -> None:
    table = nw.PAPER.with_terms("bad", yaw=[nw.Term("c_bad", "c", lambda vdot, rdot: vdot * rdot, dim.NUMBER)])
    with pytest.raises(nw.InputError, match="term c_bad: an acceleration must enter linearly"):
        trace(record(table), "held", coriolis=False)


def test_every_motion_has_an_inertia() -> None:
    with pytest.raises(nw.InputError, match="no term resists vdot"):
        compiled(nw.TermTable("bare", nw.PAPER.surge, nw.PAPER.sway[2:], nw.PAPER.yaw[1:])).constants({})


@pytest.mark.parametrize("name", ["u", "width", "Y_in"])
def test_a_coefficient_has_a_name_of_its_own(name: str) -> None:
    table = nw.PAPER.with_terms("bad", sway=[nw.Term(name, "b", cross_flow, dim.NUMBER)])
    with pytest.raises(nw.InputError, match=f"term {name}: the name already means something else"):
        compiled(table).constants({})


@pytest.mark.parametrize("name", ["k0", "t1", "lambda", "v²", "E", "abs"])
def test_a_coefficient_may_be_called_anything_else(name: str) -> None:
    one, other = (
        nw.PAPER.with_terms("own", sway=[nw.Term(own, "b", cross_flow, dim.NUMBER)]) for own in (name, "b_uv")
    )
    values = values_of(model_of(nw.PAPER))
    state = [float(column[0]) for column in states(1).values()]
    found, expected = (
        program.rhs(*state, 0.0, 0.0, 0.0, *CONTROLS, *program.constants({**values, own: 60.0}))
        for program, own in ((compiled(one), name), (compiled(other), "b_uv"))
    )
    assert found == expected


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"draft": None}, "need draft"),
        ({"b_vdot": 0.0, "b_rdot": 0.0}, "mass matrix cannot be inverted"),
        ({"b_v": float("nan")}, "mass matrix cannot be inverted; check that the coefficients are finite"),
    ],
)
def test_values_that_cannot_be_are_refused(change: dict, words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        compiled(nw.PAPER).constants({**values_of(model_of(nw.PAPER)), **change})


def test_a_free_speed_needs_a_mass() -> None:
    values = values_of(nw.published("mikkelsen2025_dtc")) | {"surge_inertia": 0.0}
    with pytest.raises(nw.InputError, match="surge_inertia"):
        compiled(nw.PAPER, "free").constants(values)


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"surge": "loose"}, "surge 'loose' is unknown"),
        ({"contact": "corner"}, "did you mean 'corners'"),
        ({"contact": [(1.0, 0.0)]}, "needs 3 points"),
        ({"contact": [1.0, 2.0, 3.0]}, "list of points"),
    ],
)
def test_unknown_choices_are_refused(choice: dict, words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        compiled(nw.PAPER, **choice)


def test_a_program_goes_to_other_processes() -> None:
    program = compiled(nw.PAPER, contact=[(1.0, 0.2), (1.0, -0.2), (-1.0, 0.0)])
    program.constants(values_of(nw.published("mikkelsen2025_dtc")))
    assert pickle.loads(pickle.dumps(program)) == program
