"""One whole step of one ship in one waterway under one law, in lines.

It holds control law, actuators, the section of the water at the ship's place, Runge-Kutta and contact. A straight canal
is a waterway with a constant section. Every engine prints these lines.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

import sympy

from narrows.codegen.choices import AFLOAT_SPEED, AFTER, COLUMNS, COUNTED, LENGTH, SHARE, TIME, WATER, Actuated, Choices
from narrows.codegen.free_motion import (
    ACCELERATIONS,
    CORNERS,
    INPUTS,
    MIDSHIP,
    OPEN,
    STATE,
    Expr,
    FreeMotion,
    exact_number,
    point_names,
    symbol,
)
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
)
from narrows.physics.rudder import gear_motion

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
        constants = self._parts[0]
        return Constants(constants.parameters, dict(constants.table))  # Exports lift more into their own.

    @property
    def _parts(self) -> tuple[Constants, tuple[Expr, ...], tuple[list[Assignment], list[Expr]]]:
        return _rate_lines(self.motion, self.moving, self.pushed)

    @property
    def parameters(self) -> dict[str, Expr]:
        """Symbols that the constants are computed from, by the names of the vocabulary."""
        used = set().union(*(expression.free_symbols for expression in self.constants.table))
        return {name: symbol for name, symbol in self.motion.names.items() if symbol in used}

    @property
    def derivatives(self) -> tuple[Expr, ...]:
        return self._parts[1]

    @property
    def lines(self) -> tuple[list[Assignment], list[Expr]]:
        """The rates as straight lines with their results."""
        return self._parts[2]

    def depend_on(self, name: str) -> bool:
        return any(symbol(name) in rate.free_symbols for rate in self.derivatives)

    def inlined(self, lines: Lines, tag: str, values: Mapping[str, Expr]) -> dict[str, Expr]:
        where = {symbol(name): value for name, value in values.items()}
        results = lines.inline(f"e{tag}_", *self.lines, where)
        return {name: lines.put(f"d{tag}_{name}", rate) for name, rate in zip(STATE, results, strict=True)}

    # How a stage of a step gets its rates.
    written = inlined

    def program(self) -> tuple[Lines, dict[str, Expr]]:
        lines = Lines()
        names = {*STATE, *self.moving}
        return lines, self.inlined(lines, "", {name: real(name) for name in names})


# The call of a function of the rates, which its printer writes, and one of its results.
RATES, ITEM = (sympy.Function(name, real=True) for name in ("rates", "item"))


class CalledRates(Rates):
    """Rates as a function that the stages of a step call: a compiler then reads their lines once."""

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        return tuple(name for name in (*STATE, *self.moving) if self.depend_on(name))

    def written(self, lines: Lines, tag: str, values: Mapping[str, Expr]) -> dict[str, Expr]:
        call = lines.put(f"rates_{tag}", RATES(*(values[name] for name in self.arguments)))
        rates = zip(STATE, self.derivatives, strict=True)
        items = {name: ITEM(call, place) if rate else rate for place, (name, rate) in enumerate(rates)}
        return {name: lines.put(f"d{tag}_{name}", item) for name, item in items.items()}


@lru_cache(maxsize=32)
def _rate_lines(
    motion: FreeMotion, moving: tuple[str, ...], is_pushed: bool
) -> tuple[Constants, tuple[Expr, ...], tuple[list[Assignment], list[Expr]]]:
    """Constants, derivatives of the state, and those as straight lines: the same for every law and contact."""
    constants = Constants({s for name, s in motion.names.items() if name not in moving})
    pushed = {f: symbol(INPUTS[f]) for f in motion.components} if is_pushed else {}
    derivatives = _derivatives(motion, constants.lift, pushed)
    return constants, derivatives, straight_lines(derivatives)


def _derivatives(motion: FreeMotion, lift: Callable[[Expr], Expr], pushes: Mapping[str, Expr]) -> tuple[Expr, ...]:
    c, s, u, v, r = (symbol(name) for name in TURNED)
    basis = [lift(expression) for expression in motion.basis]
    accelerations = dict.fromkeys(ACCELERATIONS, sympy.Integer(0))
    for force, gains, row in zip(motion.components, motion.gains, motion.pushes, strict=True):
        parts = [(lift(gain), function) for gain, function in zip(gains, basis, strict=True)]
        pushed = sum((lift(part * pushes[f]) for f, part in zip(motion.components, row, strict=True) if f in pushes), 0)
        accelerations[force] = _grouped(parts, (v, r)) + pushed
    return (u * c - v * s, u * s + v * c, -r * s, r * c, *accelerations.values())


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


@dataclass(frozen=True)
class Step:
    lines: Lines  # The program
    # State after the step; ``clearance`` [m], the smallest margin to a bank, an end of the waterway and the limit of
    # heading; ``side`` [m], positive if the starboard bank is nearer
    out: Mapping[str, Expr]

    def with_whole_steps(self) -> "Step":
        """Return the step for engines that take whole steps only."""
        whole = {real(SHARE): sympy.Integer(1)}
        lines = Lines()
        where: dict[Expr, Expr] = dict(whole)
        for line in self.lines.program:
            if line is None:
                lines.cut()
            else:
                where[line[0]] = lines.put(str(line[0]), line[1].xreplace(where))
        return Step(lines, {name: sympy.sympify(value).xreplace(where) for name, value in self.out.items()})


def step_of(rates: Rates, choices: Choices) -> Step:
    lines, z = Lines(), {name: real(name) for name in choices.kept}
    h = lines.put("h", real(LENGTH) * real(SHARE))
    moves, out = _orders(lines, choices, z)
    controls = _controls(lines, choices, z, moves)
    pushes = _pushes(lines, choices, z)

    def rate(at: Mapping[str, Expr], node: int) -> dict[str, Expr]:
        values = {**{name: at[name] for name in STATE}, **controls(NODES[node]), **pushes}
        return rate_here(lines, rates, choices, values, str(node))

    # Only the arguments of the rates are moved to each stage.
    along = ("x", "y") if choices.waterway else ()
    after = _runge_kutta(lines, z, h, rate, tuple(name for name in STATE if name in along or rates.depend_on(name)))
    if TIME in z:
        out[TIME] = lines.put("t_new", z[TIME] + h)
    out |= after
    out["clearance"], out["side"] = least_clearance(lines, choices, after)
    return Step(lines, out)


def section_at(lines: Lines, x: Expr, columns: tuple[str, ...], tag: str) -> dict[str, Expr]:
    """Write the water at a place from the table, linear between its nodes."""
    position = lines.put(f"position_{tag}", FUNCTIONS["maximum"]((x - real("x_first")) * real("cells_a_metre"), 0))
    cell = lines.put(f"cell_{tag}", FUNCTIONS["whole"](FUNCTIONS["minimum"](position, real("last_cell"))))
    part = lines.put(f"part_{tag}", FUNCTIONS["minimum"](position - cell, 1))
    section = {}
    for name in columns:
        first = 2 * (*COLUMNS, AFLOAT_SPEED).index(name)
        start, rise = (lines.put(f"{name}_{k}_{tag}", FUNCTIONS["entry"](first + k, cell)) for k in range(2))
        section[name] = lines.put(f"{name}_{tag}", start + part * rise)
    return section


def _water(lines: Lines, choices: Choices, column: str, x: Expr) -> Expr:
    """Write the water quantities of a control law at a place; a straight canal is the same everywhere."""
    if choices.waterway:
        return section_at(lines, lines.put("seen", x), (column,), f"{column}_seen")[column]
    walls = {"keel_starboard": real("wall_starboard"), "keel_port": real("wall_port")}
    return walls.get(column, sympy.Integer(0))


def _orders(lines: Lines, choices: Choices, z: Mapping[str, Expr]) -> tuple[dict[str, Expr], dict[str, Expr]]:
    """Write the law's orders: how far each actuator moves in the step, and the new memory."""
    if choices.law is None:
        return {}, {}
    asked = {**z, "dt": real(LENGTH), "current": sympy.Integer(0)}
    if choices.waterway and "current" in choices.law.tape.inputs:
        asked["current"] = lines.put("current_seen", real("current") * _water(lines, choices, "flow", z["x"]))
    inputs = {name: asked.get(name, real(name)) for name in choices.law.tape.inputs}
    water = {name: partial(_water, lines, choices, column) for name, column in WATER.items()}
    results = choices.law.tape.replay(inputs, exact_number, {**FUNCTIONS, **water})
    moves: dict[str, Expr] = {}
    out: dict[str, Expr] = {}
    for actuator in choices.law.ordered:
        name = actuator.name
        wanted = lines.put(f"{name}_order", clipped(results[name], real(f"{name}_limit")))
        if actuator.late:
            whole = _followed(lines, actuator, z, wanted, out)
        else:
            furthest = lines.put(f"{name}_reach", real(f"{name}_rate") * real(LENGTH))
            whole = lines.put(f"{name}_whole", clipped(wanted - z[name], furthest))
        moves[name] = lines.put(f"{name}_move", real(SHARE) * whole)
        out[name] = lines.put(f"{name}_new", z[name] + moves[name])
    return moves, out | {name: lines.put(f"{name}_new", results[name]) for name in choices.law.memory}


def _followed(lines: Lines, actuator: Actuated, z: Mapping[str, Expr], wanted: Expr, out: dict[str, Expr]) -> Expr:
    """Write how far a gear with dead time and lag moves an actuator in the step; orders on their way go into out."""
    name, stages = actuator.name, actuator.stages
    gear = {of: real(f"{name}_{of}") for of in ("dead_time", "lag", "dead_band", "rate")}
    whole, after = gear_motion(
        wanted, z[name], [z[stage] for stage in stages], gear, real(LENGTH), {**FUNCTIONS, "exp": sympy.exp},
        lambda of, value: lines.put(f"{name}_{of}", value),
    )  # fmt: skip
    out.update(zip(stages, after, strict=True))
    return whole


def _controls(
    lines: Lines, choices: Choices, z: Mapping[str, Expr], moves: Mapping[str, Expr]
) -> Callable[[Expr], dict[str, Expr]]:
    """Return the positions of the moving actuators at a place within the step."""
    known: dict[Expr, dict[str, Expr]] = {}

    def at(node: Expr) -> dict[str, Expr]:
        if node not in known:
            known[node] = controls = {}
            for actuator in choices.law.ordered if choices.law else ():
                name = actuator.name
                position = lines.put(f"{name}_at{len(known)}", z[name] + node * moves[name])
                if actuator.angle:
                    controls[f"cos_{name}"] = lines.put(f"cos_{name}{len(known)}", FUNCTIONS["cosine"](position))
                    controls[f"sin_{name}"] = lines.put(f"sin_{name}{len(known)}", FUNCTIONS["sine"](position))
                else:
                    controls[name] = position
        return known[node]

    return at


def _pushes(lines: Lines, choices: Choices, z: Mapping[str, Expr]) -> dict[str, Expr]:
    """External forces: others from where the middle of the step lies beyond their end."""
    if choices.pushed != "until":
        return {}
    left = lines.put("push_left", real("push_end") - (z[TIME] + real(LENGTH) / 2))
    return {
        name: lines.put(f"{name}_now", FUNCTIONS["choice"](left, real(name), real(AFTER(name))))
        for name in INPUTS.values()
    }


def section_here(
    lines: Lines, rates: Rates, values: Mapping[str, Expr], tag: str
) -> tuple[dict[str, Expr], dict[str, Expr]]:
    """Write the local straight canal at a ship's place, and the waterway there by column."""
    columns = ("starboard", "port", *(("depth",) if rates.depend_on("depth") else ()), "curvature", "flow")
    now = section_at(lines, values["x"], columns, f"stage{tag}")
    here = {
        "width": lines.put(f"width_{tag}", now["starboard"] + now["port"]),
        "depth": now.get("depth", real("depth")),
        "y": lines.put(f"off_{tag}", values["y"] - sympy.Rational(1, 2) * (now["starboard"] - now["port"])),
    }
    return {**values, **here}, now


def rate_here(lines: Lines, rates: Rates, choices: Choices, values: dict[str, Expr], tag: str) -> dict[str, Expr]:
    """Write the rates in the waterway from those of the local straight canal."""
    if not choices.waterway:
        return {**rates.written(lines, tag, values), COUNTED: values["r"]}
    here, now = section_here(lines, rates, values, tag)
    straight, curvature = rates.written(lines, tag, here), now["curvature"]
    over_ground = straight["x"] + real("current") * now["flow"]
    pace = lines.put(f"pace_{tag}", over_ground / (1 - curvature * values["y"]))
    turn = lines.put(f"turn_{tag}", values["r"] - curvature * pace)
    heading = {"cos_psi": -turn * values["sin_psi"], "sin_psi": turn * values["cos_psi"]}
    return {
        **straight,
        "x": pace,
        COUNTED: turn,
        **{name: lines.put(f"d{tag}_{name}_", slope) for name, slope in heading.items()},
    }


Rate = Callable[[Mapping[str, Expr], int], dict[str, Expr]]


def _runge_kutta(lines: Lines, z: Mapping[str, Expr], h: Expr, rate: Rate, moved: tuple[str, ...]) -> dict[str, Expr]:
    """Write the classical Runge-Kutta step, and renormalise the heading to the unit circle."""
    at, k, middle = dict(z), [], {}
    integrated = (*STATE, *(COUNTED,) * (COUNTED in z))
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
        # Additions, for processors limited by their multipliers.
        total = (k[0][name] + k[3][name]) + (middle[name] + middle[name])
        after[name] = lines.put(f"{name}_new", z[name] + sixth * total) if k[3][name] != 0 else z[name]
    size = after["cos_psi"] * after["cos_psi"] + after["sin_psi"] * after["sin_psi"]
    unit = lines.put("unit", sympy.Rational(3, 2) - sympy.Rational(1, 2) * size)
    return {**after, **{name: lines.put(f"{name}_unit", after[name] * unit) for name in ("cos_psi", "sin_psi")}}


def least_clearance(lines: Lines, choices: Choices, z: Mapping[str, Expr]) -> tuple[Expr, Expr]:
    """Write the margin to the nearest end of the voyage, and how much nearer the starboard bank is [m]."""
    left = [*ends_left(lines, choices, z).values()]
    side: Expr = sympy.Integer(0)
    if choices.contact != OPEN:
        reach = reaches(lines, choices.contact, z["cos_psi"], z["sin_psi"])
        walls = _walls(lines, choices, z["x"])
        starboard = lines.put("clearance_starboard", walls[0] - z["y"] - reach[0])
        port = lines.put("clearance_port", walls[1] + z["y"] - reach[1])
        left.insert(0, lines.put("clearance_bank", least(starboard, port)))
        side = lines.put("side", port - starboard)
    return lines.put("clearance_new", least(*left)), side


def ends_left(lines: Lines, choices: Choices, z: Mapping[str, Expr]) -> dict[str, Expr]:
    """Write the margins to every end but a bank, as ``event.cause`` takes them: a cosine, [m], [m], [m/s]."""
    left = {"heading": lines.put("heading_left", z["cos_psi"] - real("least_cos"))}
    if choices.waterway:
        left["ahead"] = lines.put("left_ahead", real("x_last") - z["x"])
        left["astern"] = lines.put("left_astern", z["x"] - real("x_first"))
    if choices.bottom:
        most = real(AFLOAT_SPEED)
        if choices.waterway:
            most = section_at(lines, z["x"], (AFLOAT_SPEED,), "ends")[AFLOAT_SPEED]
        left["afloat"] = lines.put("left_afloat", most - abs(z["u"]))
    return left


def _walls(lines: Lines, choices: Choices, x: Expr) -> tuple[Expr, Expr]:
    if not choices.waterway:
        return real("wall_starboard"), real("wall_port")
    kind = "keel" if choices.contact == MIDSHIP else "near"
    names = (f"{kind}_starboard", f"{kind}_port")
    section = section_at(lines, x, names, "after")
    return section[names[0]], section[names[1]]


def reaches(lines: Lines, contact: str | int, cosine: Expr, sine: Expr) -> tuple[Expr, Expr]:
    """Write how far a hull extends across the canal to starboard and to port of midship [m]."""
    half_beam = real("half_beam")
    if contact == MIDSHIP:
        return (lines.put("reach", half_beam * cosine),) * 2
    if contact == CORNERS:
        return (lines.put("reach", real("half_length") * abs(sine) + half_beam * cosine),) * 2
    out = [
        lines.put(f"point_{number}", real(forward) * sine + real(starboard) * cosine)
        for number, (forward, starboard) in enumerate(point_names(int(contact)))
    ]
    return lines.put("reach_starboard", greatest(*out)), lines.put("reach_port", -least(*out))
