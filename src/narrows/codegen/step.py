"""One time step of a ship in a waterway under a control law, as a straight-line program.

The program has the control law, actuators, the section of water at the ship, the Runge-Kutta stages and the clearance.
A straight canal is a waterway with a constant section. Every engine prints these lines.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache, partial

import sympy

from narrows.codegen import free_motion
from narrows.codegen.free_motion import INPUTS, STATE, Choices, Expr, FreeMotion, exact_number, symbol
from narrows.codegen.lines import (
    FUNCTIONS,
    Assignment,
    Constants,
    Lines,
    clipped,
    greatest,
    least,
    real,
    straight_lines,
    symbols_of,
)  # fmt: skip
from narrows.physics.hull import current_gradient
from narrows.physics.propeller_and_rudder import gear_motion
from narrows.quantities.names import ACCELERATIONS

TURNED = ("cos_psi", "sin_psi", "u", "v", "r")


@dataclass(frozen=True)
class Rates:
    """The rates of ``STATE`` by state, controls, section of the water and constants."""

    motion: FreeMotion  # The equations of motion
    # Quantities that change within a voyage besides the state: moving actuators, the section, external forces
    moving: tuple[str, ...]
    pushed: bool = False  # True if external forces act

    @cached_property
    def constants(self) -> Constants:
        """Quantities that stay constant through a voyage, by their names in the lines."""
        constants = _rate_lines(self)[0]
        return Constants(constants.parameters, dict(constants.table))  # Exports lift more into their own.

    @property
    def parameters(self) -> dict[str, Expr]:
        """Symbols that the constants are computed from, by the names of the vocabulary."""
        used = set().union(*map(symbols_of, self.constants.table))
        return {name: symbol for name, symbol in self.motion.names.items() if symbol in used}

    def depend_on(self, name: str) -> bool:
        return any(symbol(name) in symbols_of(rate) for rate in _rate_lines(self)[1])

    def written(self, lines: Lines, tag: str, values: Mapping[str, Expr]) -> dict[str, Expr]:
        where = {symbol(name): value for name, value in values.items()}
        results = lines.inline(f"e{tag}_", *_rate_lines(self)[2], where)
        return {name: lines.put(f"d{tag}_{name}", rate) for name, rate in zip(STATE, results, strict=True)}

    @property
    def symbols(self) -> dict[str, Expr]:
        return {name: real(name) for name in (*STATE, *self.moving)}

    def program(self) -> tuple[Lines, dict[str, Expr]]:
        lines = Lines()
        return lines, self.written(lines, "", self.symbols)


@lru_cache(maxsize=32)
def _rate_lines(rates: Rates) -> tuple[Constants, tuple[Expr, ...], tuple[list[Assignment], list[Expr]]]:
    """Constants, derivatives of the state, and those as straight lines: the same for every law and contact."""
    motion = rates.motion
    constants = Constants({s for name, s in motion.names.items() if name not in rates.moving})
    pushes, lift = {f: symbol(INPUTS[f]) for f in motion.components} if rates.pushed else {}, constants.lift
    c, s, u, v, r = (symbol(name) for name in TURNED)
    basis = [lift(expression) for expression in motion.basis]
    accelerations = dict.fromkeys(ACCELERATIONS, sympy.Integer(0))
    for force, gains, row in zip(motion.components, motion.gains, motion.pushes, strict=True):
        parts = [(lift(gain), function) for gain, function in zip(gains, basis, strict=True)]
        pushed = sum((lift(part * pushes[f]) for f, part in zip(motion.components, row, strict=True) if f in pushes), 0)
        accelerations[force] = _grouped(parts, (v, r)) + pushed
    derivatives = (u * c - v * s, u * s + v * c, -r * s, r * c, *accelerations.values())
    return constants, derivatives, straight_lines(derivatives)


def _grouped(parts: Iterable[tuple[Expr, Expr]], factors: Sequence[Expr]) -> Expr:
    """Sum gains times functions with factors collected: v (k0 + k1 |v|), not k0 v + k1 |v| v."""
    total, gathered = sympy.Integer(0), dict.fromkeys(factors, sympy.Integer(0))
    for gain, basis in parts:
        factor = next((f for f in factors if f in sympy.Mul.make_args(basis)), None)
        if factor is None:
            total += gain * basis
        else:
            gathered[factor] += gain * (basis / factor)
    return total + sum((factor * inner for factor, inner in gathered.items()), sympy.Integer(0))


# The classical Runge-Kutta method of order 4: places of its stages within the step.
NODES = (sympy.Integer(0), sympy.Rational(1, 2), sympy.Rational(1, 2), sympy.Integer(1))


def step_of(rates: Rates, choices: Choices, whole: bool = False) -> tuple[Lines, dict[str, Expr]]:
    """Write a step, or a share of it; ``whole`` is for engines that take whole steps only."""
    # Its results: the state after it; ``clearance`` [m], the smallest margin to a bank, an end of the waterway and the
    # limit of heading; ``side`` [m], positive if the starboard bank is nearer.
    lines, z = Lines(), {name: real(name) for name in choices.kept}
    share = sympy.Integer(1) if whole else real(free_motion.SHARE)
    h = lines.put("h", real(free_motion.LENGTH) * share)
    moves, out = _orders(lines, choices, z, share)
    controls = _controls(lines, choices, z, moves)
    pushes = _pushes(lines, choices, z)

    def rate(at: Mapping[str, Expr], node: int) -> dict[str, Expr]:
        values = {**{name: at[name] for name in STATE}, **controls(NODES[node]), **pushes}
        return rate_here(lines, rates, choices, values, str(node))

    # A stage needs only the states that the rates depend on.
    along = ("x", "y") if choices.waterway else ()
    after = _runge_kutta(lines, z, h, rate, tuple(name for name in STATE if name in along or rates.depend_on(name)))
    if free_motion.TIME in z:
        out[free_motion.TIME] = lines.put("t_new", z[free_motion.TIME] + h)
    out |= after
    out["clearance"], out["side"] = least_clearance(lines, choices, after)
    return lines, out


def section_at(lines: Lines, choices: Choices, x: Expr, columns: tuple[str, ...], tag: str) -> dict[str, Expr]:
    """Write columns of the table of sections at x, linear between its nodes; for the current across also its slope."""
    position = lines.put(f"position_{tag}", FUNCTIONS["maximum"]((x - real("x_first")) * real("cells_a_metre"), 0))
    cell = lines.put(f"cell_{tag}", FUNCTIONS["whole"](FUNCTIONS["minimum"](position, real("last_cell"))))
    part = lines.put(f"part_{tag}", FUNCTIONS["minimum"](position - cell, 1))
    section = {}
    for name in columns:
        first = 2 * choices.columns.index(name)
        start, rise = (lines.put(f"{name}_{k}_{tag}", FUNCTIONS["entry"](first + k, cell)) for k in range(2))
        section[name] = lines.put(f"{name}_{tag}", start + part * rise)
        if name == "across":
            section["across_slope"] = lines.put(f"{name}_slope_{tag}", rise * real("cells_a_metre"))
    return section


def _water(lines: Lines, choices: Choices, column: str, x: Expr) -> Expr:
    """Write a water quantity that a control law reads at x; a straight canal is the same everywhere."""
    if choices.waterway:
        return section_at(lines, choices, lines.put("seen", x), (column,), f"{column}_seen")[column]
    walls = {"keel_starboard": real("wall_starboard"), "keel_port": real("wall_port")}
    return walls.get(column, sympy.Integer(0))


def _orders(
    lines: Lines, choices: Choices, z: Mapping[str, Expr], share: Expr
) -> tuple[dict[str, Expr], dict[str, Expr]]:
    """Write the law's orders: the change of each actuator's position in the step, and the new memory."""
    if choices.law is None:
        return {}, {}
    known = {**z, "dt": real(free_motion.LENGTH), "current": sympy.Integer(0)}
    if choices.waterway and "current" in choices.law.trace.inputs:
        along = real("current") * _water(lines, choices, "flow", z["x"])
        if choices.across == "field":
            along += _water(lines, choices, "shear", z["x"]) * z["y"]
        known["current"] = lines.put("current_seen", along)
    inputs = {name: known.get(name, real(name)) for name in choices.law.trace.inputs}
    water = {name: partial(_water, lines, choices, column) for name, column in free_motion.WATER.items()}
    results = choices.law.trace.replay(inputs, exact_number, {**FUNCTIONS, **water}, lines.put)
    moves: dict[str, Expr] = {}
    out: dict[str, Expr] = {}
    for actuator in choices.law.ordered:
        name = actuator.name
        wanted = lines.put(f"{name}_order", clipped(results[name], real(f"{name}_limit")))
        if actuator.late:
            gear = {part: real(f"{name}_{part}") for part in ("dead_time", "lag", "dead_band", "rate")}
            whole, after = gear_motion(
                wanted, z[name], [z[stage] for stage in actuator.stages], gear, real(free_motion.LENGTH),
                {**FUNCTIONS, "exp": sympy.exp}, partial(lambda own, part, of: lines.put(f"{own}_{part}", of), name),
            )  # fmt: skip
            out.update(zip(actuator.stages, after, strict=True))
        else:
            furthest = lines.put(f"{name}_reach", real(f"{name}_rate") * real(free_motion.LENGTH))
            whole = lines.put(f"{name}_whole", clipped(wanted - z[name], furthest))
        moves[name] = lines.put(f"{name}_move", share * whole)
        out[name] = lines.put(f"{name}_new", z[name] + moves[name])
    return moves, out | {name: lines.put(f"{name}_new", results[name]) for name in choices.law.memory}


def _controls(
    lines: Lines, choices: Choices, z: Mapping[str, Expr], moves: Mapping[str, Expr]
) -> Callable[[Expr], dict[str, Expr]]:
    """Return a function that writes the actuators at a node of the step, once: positions, or cosine and sine."""

    @cache
    def at(node: Expr) -> dict[str, Expr]:
        controls, place = dict[str, Expr](), 1 + 2 * node
        for actuator in choices.law.ordered if choices.law else ():
            name = actuator.name
            position = lines.put(f"{name}_at{place}", z[name] + node * moves[name])
            forms = [FUNCTIONS[form](position) for form in ("cosine", "sine")] if actuator.angle else [position]
            pairs = zip(actuator.controls, forms, strict=True)
            controls |= {control: lines.put(f"{control}{place}", form) for control, form in pairs}
        return controls

    return at


def _pushes(lines: Lines, choices: Choices, z: Mapping[str, Expr]) -> dict[str, Expr]:
    """Write the external forces of the step: those of the next piece if the middle of the step lies in it."""
    if choices.pushed != "until":
        return {name: real(name) for name in INPUTS.values() if choices.pushed == "always" and name in choices.moving}
    left = lines.put("push_left", real("push_end") - (z[free_motion.TIME] + real(free_motion.LENGTH) / 2))
    return {
        name: lines.put(f"{name}_now", FUNCTIONS["choice"](left, real(name), real(free_motion.AFTER(name))))
        for name in INPUTS.values()
    }


def section_here(
    lines: Lines, rates: Rates, choices: Choices, values: Mapping[str, Expr], tag: str
) -> tuple[dict[str, Expr], dict[str, Expr]]:
    columns = ("starboard", "port", *(("depth",) if rates.depend_on("depth") else ()), "curvature", "flow")
    columns += free_motion.FIELD * (choices.across == "field")
    now = section_at(lines, choices, values["x"], columns, f"stage{tag}")
    here = {
        "width": lines.put(f"width_{tag}", now["starboard"] + now["port"]),
        "depth": now.get("depth", real("depth")),
        "y": lines.put(f"off_{tag}", values["y"] - sympy.Rational(1, 2) * (now["starboard"] - now["port"])),
    }
    if choices.across == "field":
        here |= _in_gradient(lines, values, now, tag)
    return {**values, **here}, now


def _in_gradient(lines: Lines, values: Mapping[str, Expr], now: Mapping[str, Expr], tag: str) -> dict[str, Expr]:
    """Write the yaw rate through the water, and the inertial forces on a floating ship in a current that varies."""
    slope = lines.put(f"across_rise_{tag}", now["across_slope"] / (1 - now["curvature"] * values["y"]))
    c, s, u, v = (values[name] for name in TURNED[:4])
    turn, *accelerations = current_gradient(c, s, u, v, slope, now["shear"])
    mass = sympy.Mul(*(real(name) for name in ("density", "block_coefficient", "length", "beam", "draft")))
    forces = {name: values.get(name, sympy.Integer(0)) for name in INPUTS.values()}
    for name, acceleration in zip(forces, accelerations, strict=False):
        forces[name] = lines.put(f"{name}_{tag}", forces[name] - mass * acceleration)
    return {**forces, "r": lines.put(f"r_water_{tag}", values["r"] - turn)}


def rate_here(lines: Lines, rates: Rates, choices: Choices, values: dict[str, Expr], tag: str) -> dict[str, Expr]:
    """Write the rates in the waterway from those of the local straight canal."""
    here, now = section_here(lines, rates, choices, values, tag) if choices.waterway else (values, {})
    straight = rates.written(lines, tag, here)
    if choices.across != "none":
        across = now["across"] if choices.across == "field" else real(free_motion.CURRENT_ACROSS)
        straight["y"] = lines.put(f"d{tag}_y_", straight["y"] + across)
    if not choices.waterway:
        return {**straight, free_motion.COUNTED: values["r"]}
    curvature = now["curvature"]
    along = real("current") * now["flow"] + now.get("shear", 0) * values["y"]
    pace = lines.put(f"pace_{tag}", (straight["x"] + along) / (1 - curvature * values["y"]))
    turn = lines.put(f"turn_{tag}", values["r"] - curvature * pace)
    heading = {"cos_psi": -turn * values["sin_psi"], "sin_psi": turn * values["cos_psi"]}
    return {
        **straight,
        "x": pace,
        free_motion.COUNTED: turn,
        **{name: lines.put(f"d{tag}_{name}_", slope) for name, slope in heading.items()},
    }


Rate = Callable[[Mapping[str, Expr], int], dict[str, Expr]]


def _runge_kutta(lines: Lines, z: Mapping[str, Expr], h: Expr, rate: Rate, moved: tuple[str, ...]) -> dict[str, Expr]:
    """Write the classical Runge-Kutta step, and renormalise the heading to the unit circle."""
    at, k, middle = dict(z), [], {}
    integrated = (*STATE, *(free_motion.COUNTED,) * (free_motion.COUNTED in z))
    for node in range(4):
        k.append(rate(at, node))
        if node == 2:
            middle = {name: lines.put(f"middle_{name}", k[1][name] + k[2][name]) for name in integrated}
        if node < 3:
            ahead = lines.put(f"h_{node}", NODES[node + 1] * h)
            steps = {name: ahead * k[node][name] for name in moved if k[node][name] != 0}
            at = {**z, **{name: lines.put(f"{name}_at{node + 1}", z[name] + step) for name, step in steps.items()}}
            lines.cut()
    sixth, after = lines.put("sixth", h * sympy.Rational(1, 6)), {}
    for name in integrated:
        # A sum instead of a product with 2: multipliers are the bottleneck of many processors.
        total = (k[0][name] + k[3][name]) + (middle[name] + middle[name])
        after[name] = lines.put(f"{name}_new", z[name] + sixth * total) if k[3][name] != 0 else z[name]
    size = after["cos_psi"] * after["cos_psi"] + after["sin_psi"] * after["sin_psi"]
    unit = lines.put("unit", sympy.Rational(3, 2) - sympy.Rational(1, 2) * size)
    return {**after, **{name: lines.put(f"{name}_unit", after[name] * unit) for name in ("cos_psi", "sin_psi")}}


def least_clearance(lines: Lines, choices: Choices, z: Mapping[str, Expr]) -> tuple[Expr, Expr]:
    """Write the margin to the nearest end of the voyage, and how much nearer the starboard bank is [m]."""
    left = [*ends_left(lines, choices, z).values()]
    side: Expr = sympy.Integer(0)
    if choices.contact != free_motion.OPEN:
        reach = reaches(lines, choices.contact, z["cos_psi"], z["sin_psi"])
        walls = real("wall_starboard"), real("wall_port")
        if choices.waterway:
            kind = "keel" if choices.contact == free_motion.MIDSHIP else "near"
            walls = tuple(section_at(lines, choices, z["x"], (f"{kind}_starboard", f"{kind}_port"), "after").values())
        starboard = lines.put("clearance_starboard", walls[0] - z["y"] - reach[0])
        port = lines.put("clearance_port", walls[1] + z["y"] - reach[1])
        left.insert(0, lines.put("clearance_bank", least(starboard, port)))
        side = lines.put("side", port - starboard)
    return lines.put("clearance_new", least(*left)), side


def ends_left(lines: Lines, choices: Choices, z: Mapping[str, Expr]) -> dict[str, Expr]:
    """Write the margins to all ends except the bank, in the order of ``event.cause``: heading [1], [m], [m], [m/s]."""
    left = {"heading": lines.put("heading_left", z["cos_psi"] - real("least_cos"))}
    if choices.waterway:
        left["ahead"] = lines.put("left_ahead", real("x_last") - z["x"])
        left["astern"] = lines.put("left_astern", z["x"] - real("x_first"))
    if choices.bottom:
        most = real(free_motion.AFLOAT_SPEED)
        if choices.waterway:
            most = section_at(lines, choices, z["x"], (free_motion.AFLOAT_SPEED,), "ends")[free_motion.AFLOAT_SPEED]
        left["afloat"] = lines.put("left_afloat", most - abs(z["u"]))
    return left


def reaches(lines: Lines, contact: str | int, cosine: Expr, sine: Expr) -> tuple[Expr, Expr]:
    """Write how far a hull extends across the canal to starboard and to port of midship [m]."""
    half_beam = real("half_beam")
    if contact == free_motion.MIDSHIP:
        return (lines.put("reach", half_beam * cosine),) * 2
    if contact == free_motion.CORNERS:
        return (lines.put("reach", real("half_length") * abs(sine) + half_beam * cosine),) * 2
    out = [
        lines.put(f"point_{n}", real(f"outline_forward_{n}") * sine + real(f"outline_starboard_{n}") * cosine)
        for n in range(int(contact))
    ]
    return lines.put("reach_starboard", greatest(*out)), lines.put("reach_port", -least(*out))
