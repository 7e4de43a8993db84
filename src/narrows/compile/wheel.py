# The loop of a fleet under autopilots. This text is appended to a generated kernel, whose header has jit, cached and
# np, and whose equations are rhs, gap and of_vessel; here they are declared for those who read and check it.
from math import atan2, cos, sin
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    Array = np.ndarray

    def jit(function: Any) -> Any: ...
    def cached(function: Any) -> Any: ...
    def rhs(*arguments: Any) -> Any: ...
    def gap(*arguments: Any) -> Any: ...
    def of_vessel(constants: "Array", vessel: int) -> Any: ...


# columns of a pilot: what is held, the gains, the gear; then the push and until when
HOLD_Y, HOLD_PSI, HOLD_V, HOLD_RUDDER, BY_Y, BY_PSI, BY_V, BY_R = 0, 1, 2, 3, 4, 5, 6, 7
LIMIT, RATE, REVOLUTIONS, PUSH_Y, PUSH_N, PUSH_TIME = 8, 9, 10, 11, 12, 13
# where a keel meets the banks, and the hull's half length and beam; the last steps, that count as the end
WALL_PORT, WALL_STARBOARD, HALF_LENGTH, HALF_BEAM, LATE = 14, 15, 16, 17, 18
# columns of what is kept
KEPT_FARTHEST, KEPT_LATE, KEPT_RUDDER = 0, 1, 2
AFLOAT, GROUNDED, DIVERGED, OUTSIDE = 0, 1, 2, 3
LEAST_COS, MOST_SPEED, MOST_RATE = 0, 1, 2


@jit
def turning(own: "Array", rudder: float, y: float, c: float, s: float, v: float, r: float, h: float) -> float:
    """Rate of the rudder over a step, towards the order and not beyond it."""
    off = own[BY_Y] * (y - own[HOLD_Y]) + own[BY_PSI] * (atan2(s, c) - own[HOLD_PSI])
    order = own[HOLD_RUDDER] - (off + own[BY_V] * (v - own[HOLD_V]) + own[BY_R] * r)
    wanted = min(max(order, -own[LIMIT]), own[LIMIT]) - rudder
    reach = own[RATE] * h
    rate: float = min(max(wanted, -reach), reach) / h
    return rate


@jit
def stepped(state: "Any", rudder: float, rate: float, push: "Any", revolutions: float, h: float, own: "Any") -> "Any":
    """One classical Runge-Kutta step while the rudder turns steadily."""
    x, y, c, s, u, v, r = state
    half, whole = rudder + 0.5 * h * rate, rudder + h * rate
    now, mid, last = (cos(rudder), sin(rudder)), (cos(half), sin(half)), (cos(whole), sin(whole))
    p, q, n = 0.0, push, revolutions
    a = rhs(x, y, c, s, u, v, r, p, q[0], q[1], now[0], now[1], n, *own)
    g = 0.5 * h
    b = rhs(
        x + g * a[0], y + g * a[1], c + g * a[2], s + g * a[3], u + g * a[4], v + g * a[5], r + g * a[6],
        p, q[0], q[1], mid[0], mid[1], n, *own,
    )  # fmt: skip
    d = rhs(
        x + g * b[0], y + g * b[1], c + g * b[2], s + g * b[3], u + g * b[4], v + g * b[5], r + g * b[6],
        p, q[0], q[1], mid[0], mid[1], n, *own,
    )  # fmt: skip
    e = rhs(
        x + h * d[0], y + h * d[1], c + h * d[2], s + h * d[3], u + h * d[4], v + h * d[5], r + h * d[6],
        p, q[0], q[1], last[0], last[1], n, *own,
    )  # fmt: skip
    k = h / 6.0
    c += k * (a[2] + 2.0 * (b[2] + d[2]) + e[2])
    s += k * (a[3] + 2.0 * (b[3] + d[3]) + e[3])
    unit = 1.5 - 0.5 * (c * c + s * s)
    return (
        x + k * (a[0] + 2.0 * (b[0] + d[0]) + e[0]), y + k * (a[1] + 2.0 * (b[1] + d[1]) + e[1]),
        c * unit, s * unit, u + k * (a[4] + 2.0 * (b[4] + d[4]) + e[4]),
        v + k * (a[5] + 2.0 * (b[5] + d[5]) + e[5]), r + k * (a[6] + 2.0 * (b[6] + d[6]) + e[6]),
    )  # fmt: skip


@jit
def fate_of(state: "Any", limits: "Array", own: "Any", pilot: "Array") -> int:
    """An outcome, or AFLOAT for a vessel that sails on."""
    _, y, c, s, u, v, r = state
    if not (abs(u) < limits[MOST_SPEED] and abs(v) < limits[MOST_SPEED] and abs(r) < limits[MOST_RATE]):
        return DIVERGED
    reach = pilot[HALF_LENGTH] * abs(s) + pilot[HALF_BEAM] * c
    if y + reach >= pilot[WALL_STARBOARD] or reach - y >= pilot[WALL_PORT] or not gap(y, c, s, *own) > 0.0:
        return GROUNDED
    return OUTSIDE if c <= limits[LEAST_COS] else AFLOAT


@cached
def helmed(
    start: "Array", pace: "Array", steps: "Array", pilots: "Array", constants: "Array", limits: "Array",
    kept: "Array", codes: "Array",
) -> None:  # fmt: skip
    """Sail every vessel to her end, and keep how far off and how hard over she was."""
    for vessel in range(len(codes)):
        own, pilot, h = of_vessel(constants, vessel), pilots[vessel], pace[vessel]
        z = start[vessel]
        state = (z[0], z[1], z[2], z[3], z[4], z[5], z[6])
        rudder, most, far, late, fate, step = pilot[HOLD_RUDDER], abs(pilot[HOLD_RUDDER]), 0.0, 0.0, AFLOAT, 0
        while step < steps[vessel] and fate == AFLOAT:
            rate = turning(pilot, rudder, state[1], state[2], state[3], state[5], state[6], h)
            blown = 1.0 if (step + 0.5) * h < pilot[PUSH_TIME] else 0.0
            push = (blown * pilot[PUSH_Y], blown * pilot[PUSH_N])
            state = stepped(state, rudder, rate, push, pilot[REVOLUTIONS], h, own)
            rudder += h * rate
            off = abs(state[1] - pilot[HOLD_Y])
            most, far = max(most, abs(rudder)), max(far, off)
            late = max(late, off) if step >= steps[vessel] - pilot[LATE] else late
            fate = fate_of(state, limits, own, pilot)
            step += 1
        kept[vessel, KEPT_FARTHEST], kept[vessel, KEPT_LATE], kept[vessel, KEPT_RUDDER] = far, late, most
        codes[vessel] = fate
