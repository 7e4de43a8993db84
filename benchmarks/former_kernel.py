"""The kernel of the paper's table as the engine before this one made it: text of its generated module, kept to compare.

Its mass matrix, coefficients, ship, canal and water are arguments; no rudder, no waterway, no control law."""

import numba
import numpy as np
from numpy import float64 as real

FAST = {"nsz", "contract"}  # fused multiply-add, nothing that reorders: the mirrored voyage is the mirror to the bit
jit = numba.njit(fastmath=FAST, error_model="numpy", nogil=True)
cached = numba.njit(fastmath=FAST, error_model="numpy", nogil=True, cache=True)
LANES, FIELDS = 64, 34


PARAMETERS = (
    "b_vdot",
    "b_rdot",
    "b_v",
    "b_r",
    "b_vv",
    "b_rr",
    "b_bank",
    "c_vdot",
    "c_rdot",
    "c_v",
    "c_r",
    "c_vv",
    "c_rr",
    "c_bank",
    "length",
    "beam",
    "draft",
    "block_coefficient",
    "width",
    "density",
    "heave",
)


def constants(
    b_vdot,
    b_rdot,
    b_v,
    b_r,
    b_vv,
    b_rr,
    b_bank,
    c_vdot,
    c_rdot,
    c_v,
    c_r,
    c_vv,
    c_rr,
    c_bank,
    length,
    beam,
    draft,
    block_coefficient,
    width,
    density,
    heave,
):
    t0 = 0.5 * beam
    t1 = 1.0 / (b_vdot * c_rdot - b_rdot * c_vdot)
    t2 = b_rdot * t1
    t3 = c_rdot * t1
    t4 = t0 * block_coefficient * density * (heave + draft)
    t5 = b_bank * t4 * length
    t6 = c_bank * t4 * length * length
    t7 = c_vdot * t1
    t8 = b_vdot * t1
    return (
        -t0,
        0.5 * width,
        width,
        c_v * t2 - b_v * t3,
        b_rdot * c_r * t1 - b_r * t3,
        c_vv * t2 - b_vv * t3,
        c_rr * t2 - b_rr * t3,
        t2 * t6 + t3 * t5,
        b_v * t7 - c_v * t8,
        b_r * t7 - c_r * t8,
        b_vv * c_vdot * t1 - c_vv * t8,
        b_rr * t7 - c_rr * t8,
        -t5 * t7 - t6 * t8,
        -0.5 * length,
    )


@jit
def rhs(x, y, cos_psi, sin_psi, u, v, r, k0, k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11, k12, k13):
    t0 = abs(r)
    t1 = abs(v)
    t2 = y * y
    t3 = k1 + cos_psi * k0
    t5 = t3 * t3 - t2
    t4 = cos_psi * y * u * u * (k2 * t3 - real(2.0) * t2) / (t5 * t5)
    return (
        cos_psi * u - sin_psi * v,
        cos_psi * v + sin_psi * u,
        -r * sin_psi,
        cos_psi * r,
        real(0.0),
        k7 * t4 + r * (k4 + k6 * t0) + v * (k3 + k5 * t1),
        k12 * t4 + r * (k9 + k11 * t0) + v * (k8 + k10 * t1),
    )


@jit
def gap(y, cos_psi, sin_psi, k0, k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11, k12, k13):
    return k1 + cos_psi * k0 + k13 * abs(sin_psi) - abs(y)


@jit
def lean(y, cos_psi, sin_psi, k0, k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11, k12, k13):
    return y


@jit
def uniform(constants):
    return (
        constants[0],
        constants[1],
        constants[2],
        constants[3],
        constants[4],
        constants[5],
        constants[6],
        constants[7],
        constants[8],
        constants[9],
        constants[10],
        constants[11],
        constants[12],
        constants[13],
    )


@jit
def of_lane(block, lane, constants):
    return constants


@jit
def take_constants(block, lane, constants, vessel):
    pass


@jit
def step(block, limits, constants):
    least_cos, most_speed, most_rate = limits[LEAST_COS], limits[MOST_SPEED], limits[MOST_RATE]
    all_well = True
    for lane in range(LANES):
        x = block[0 * LANES + lane]
        y = block[1 * LANES + lane]
        cos_psi = block[2 * LANES + lane]
        sin_psi = block[3 * LANES + lane]
        u = block[4 * LANES + lane]
        v = block[5 * LANES + lane]
        r = block[6 * LANES + lane]
        own = of_lane(block, lane, constants)
        pace = block[7 * LANES + lane]
        d_x, d_y, d_cos_psi, d_sin_psi, udot, vdot, rdot = rhs(x, y, cos_psi, sin_psi, u, v, r, *own)
        ahead = real(0.5) * pace
        block[22 * LANES + lane] = d_x
        block[17 * LANES + lane] = block[1 * LANES + lane] + ahead * d_y
        block[23 * LANES + lane] = d_y
        block[18 * LANES + lane] = block[2 * LANES + lane] + ahead * d_cos_psi
        block[24 * LANES + lane] = d_cos_psi
        block[19 * LANES + lane] = block[3 * LANES + lane] + ahead * d_sin_psi
        block[25 * LANES + lane] = d_sin_psi
        block[20 * LANES + lane] = block[5 * LANES + lane] + ahead * vdot
        block[26 * LANES + lane] = vdot
        block[21 * LANES + lane] = block[6 * LANES + lane] + ahead * rdot
        block[27 * LANES + lane] = rdot
    all_well = True
    for lane in range(LANES):
        x = block[0 * LANES + lane]
        y = block[17 * LANES + lane]
        cos_psi = block[18 * LANES + lane]
        sin_psi = block[19 * LANES + lane]
        u = block[4 * LANES + lane]
        v = block[20 * LANES + lane]
        r = block[21 * LANES + lane]
        own = of_lane(block, lane, constants)
        pace = block[7 * LANES + lane]
        d_x, d_y, d_cos_psi, d_sin_psi, udot, vdot, rdot = rhs(x, y, cos_psi, sin_psi, u, v, r, *own)
        ahead = real(0.5) * pace
        block[28 * LANES + lane] = d_x
        block[17 * LANES + lane] = block[1 * LANES + lane] + ahead * d_y
        block[29 * LANES + lane] = d_y
        block[18 * LANES + lane] = block[2 * LANES + lane] + ahead * d_cos_psi
        block[30 * LANES + lane] = d_cos_psi
        block[19 * LANES + lane] = block[3 * LANES + lane] + ahead * d_sin_psi
        block[31 * LANES + lane] = d_sin_psi
        block[20 * LANES + lane] = block[5 * LANES + lane] + ahead * vdot
        block[32 * LANES + lane] = vdot
        block[21 * LANES + lane] = block[6 * LANES + lane] + ahead * rdot
        block[33 * LANES + lane] = rdot
    all_well = True
    for lane in range(LANES):
        x = block[0 * LANES + lane]
        y = block[17 * LANES + lane]
        cos_psi = block[18 * LANES + lane]
        sin_psi = block[19 * LANES + lane]
        u = block[4 * LANES + lane]
        v = block[20 * LANES + lane]
        r = block[21 * LANES + lane]
        own = of_lane(block, lane, constants)
        pace = block[7 * LANES + lane]
        d_x, d_y, d_cos_psi, d_sin_psi, udot, vdot, rdot = rhs(x, y, cos_psi, sin_psi, u, v, r, *own)
        ahead = pace
        block[28 * LANES + lane] += d_x
        block[17 * LANES + lane] = block[1 * LANES + lane] + ahead * d_y
        block[29 * LANES + lane] += d_y
        block[18 * LANES + lane] = block[2 * LANES + lane] + ahead * d_cos_psi
        block[30 * LANES + lane] += d_cos_psi
        block[19 * LANES + lane] = block[3 * LANES + lane] + ahead * d_sin_psi
        block[31 * LANES + lane] += d_sin_psi
        block[20 * LANES + lane] = block[5 * LANES + lane] + ahead * vdot
        block[32 * LANES + lane] += vdot
        block[21 * LANES + lane] = block[6 * LANES + lane] + ahead * rdot
        block[33 * LANES + lane] += rdot
    all_well = True
    for lane in range(LANES):
        x = block[0 * LANES + lane]
        y = block[17 * LANES + lane]
        cos_psi = block[18 * LANES + lane]
        sin_psi = block[19 * LANES + lane]
        u = block[4 * LANES + lane]
        v = block[20 * LANES + lane]
        r = block[21 * LANES + lane]
        own = of_lane(block, lane, constants)
        pace = block[7 * LANES + lane]
        d_x, d_y, d_cos_psi, d_sin_psi, udot, vdot, rdot = rhs(x, y, cos_psi, sin_psi, u, v, r, *own)
        sixth = pace * real(1.0 / 6.0)
        block[10 * LANES + lane] = block[0 * LANES + lane]
        x = block[0 * LANES + lane] + sixth * (
            (block[22 * LANES + lane] + d_x) + (block[28 * LANES + lane] + block[28 * LANES + lane])
        )
        block[11 * LANES + lane] = block[1 * LANES + lane]
        y = block[1 * LANES + lane] + sixth * (
            (block[23 * LANES + lane] + d_y) + (block[29 * LANES + lane] + block[29 * LANES + lane])
        )
        block[12 * LANES + lane] = block[2 * LANES + lane]
        cos_psi = block[2 * LANES + lane] + sixth * (
            (block[24 * LANES + lane] + d_cos_psi) + (block[30 * LANES + lane] + block[30 * LANES + lane])
        )
        block[13 * LANES + lane] = block[3 * LANES + lane]
        sin_psi = block[3 * LANES + lane] + sixth * (
            (block[25 * LANES + lane] + d_sin_psi) + (block[31 * LANES + lane] + block[31 * LANES + lane])
        )
        block[15 * LANES + lane] = block[5 * LANES + lane]
        v = block[5 * LANES + lane] + sixth * (
            (block[26 * LANES + lane] + vdot) + (block[32 * LANES + lane] + block[32 * LANES + lane])
        )
        block[16 * LANES + lane] = block[6 * LANES + lane]
        r = block[6 * LANES + lane] + sixth * (
            (block[27 * LANES + lane] + rdot) + (block[33 * LANES + lane] + block[33 * LANES + lane])
        )
        unit = real(1.5) - real(0.5) * (cos_psi * cos_psi + sin_psi * sin_psi)
        cos_psi, sin_psi = cos_psi * unit, sin_psi * unit
        block[0 * LANES + lane] = x
        block[1 * LANES + lane] = y
        block[2 * LANES + lane] = cos_psi
        block[3 * LANES + lane] = sin_psi
        block[5 * LANES + lane] = v
        block[6 * LANES + lane] = r
        left = block[8 * LANES + lane] - real(1.0)
        block[8 * LANES + lane] = left
        room = gap(y, cos_psi, sin_psi, *own)
        well = (room > real(0.0)) & (left > real(0.0)) & (cos_psi > least_cos)
        well = well & (abs(v) < most_speed) & (abs(r) < most_rate) & (abs(u) < most_speed)
        block[9 * LANES + lane] = real(0.0) if well else real(1.0)
        all_well = all_well & well
    return not all_well


"""The bookkeeping of a block of lanes: who sails in which, who has arrived, and where exactly a hull met a bank.

Never imported: its text ends every generated kernel, below the functions of that model (see ``kernel``), so that
Numba keeps the whole as one file. A block is ONE flat array, field after field, each field LANES long.

A vessel is one lane's work until something ends its voyage; then the lane takes the next vessel from the queue.
When a step carried a hull through a bank the lane goes back to where it was and tries a shorter step, sized by the
secant of the gap, beside its neighbours' whole ones: locating a contact costs two or three lane-steps.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeVar

    Function = TypeVar("Function", bound=Callable[..., Any])
    Array = np.ndarray[Any, Any]
    LANES = FIELDS = 0
    real = np.float64

    def jit(function: Function) -> Function:
        """Compile."""

    def cached(function: Function) -> Function:
        """Compile once for all processes."""

    def gap(y: float, cos_psi: float, sin_psi: float, *constants: float) -> float:
        """Room between hull and bank [m]."""

    def lean(y: float, cos_psi: float, sin_psi: float, *constants: float) -> float:
        """Positive where starboard is the nearer bank."""

    def step(block: Array, limits: Array, constants: Any) -> bool:
        """Step every lane; return whether any wants attention."""

    def uniform(constants: Array) -> Any:
        """Give the constants of the whole fleet."""

    def of_lane(block: Array, lane: int, constants: Any) -> Any:
        """Give the constants of a lane."""

    def take_constants(block: Array, lane: int, constants: Array, vessel: int) -> None:
        """Copy a vessel's own constants into her lane."""


# fields of a lane: the state, as STATE orders it, then these; OLD is the state before the last step
STATE_FIELDS, Y, COS, SIN, U, V, R = 7, 1, 2, 3, 4, 5, 6
STEP, LEFT, FLAG, OLD = 7, 8, 9, 10
# a lane's page in the book: whole steps planned and left; seconds into the last step; the rest of that step and the
# gap at either end of it; tries to meet the bank in it
STEPS, REMAINING, CLOCK, SPAN, LOW, HIGH, TRIES, COLUMNS = 0, 1, 2, 3, 4, 5, 6, 7
OUTCOME, SIDE, COUNT = 0, 1, 2
# entries of limits
LEAST_COS, MOST_SPEED, MOST_RATE, TOLERANCE, NEAR = 0, 1, 2, 3, 4
RUNNING, AFLOAT, GROUNDED, DIVERGED, OUTSIDE = -1, 0, 1, 2, 3
MOST_TRIES, HALVE_EACH = 80, 8
CACHE_LINE = 16  # numbers: 64 bytes in single precision, two lines in double


@jit
def restore(block: "Array", lane: int) -> None:
    for field in range(STATE_FIELDS):
        block[field * LANES + lane] = block[(OLD + field) * LANES + lane]


@jit
def room_of(block: "Array", lane: int, constants: "Any") -> float:
    return gap(block[Y * LANES + lane], block[COS * LANES + lane], block[SIN * LANES + lane], *constants)


@jit
def is_sane(block: "Array", lane: int, room: float, limits: "Array") -> bool:
    slow = abs(block[U * LANES + lane]) < limits[MOST_SPEED] and abs(block[V * LANES + lane]) < limits[MOST_SPEED]
    return slow and abs(block[R * LANES + lane]) < limits[MOST_RATE] and room == room  # not NaN


@jit
def shorten(block: "Array", lane: int, book: "Array", limits: "Array") -> int:
    """Set up the next try from the secant of the gap, now and then a half in case the secant crawls."""
    book[lane, TRIES] += 1
    if book[lane, TRIES] > MOST_TRIES:
        return GROUNDED if book[lane, LOW] <= limits[NEAR] else DIVERGED
    share = 0.5
    if book[lane, HIGH] < 0 and book[lane, TRIES] % HALVE_EACH != 0:
        share = book[lane, LOW] / (book[lane, LOW] - book[lane, HIGH])
    block[STEP * LANES + lane] = share * book[lane, SPAN]
    block[LEFT * LANES + lane] = 1
    return RUNNING


@jit
def attend(block: "Array", lane: int, book: "Array", limits: "Array", constants: "Any") -> int:
    """Say what becomes of a lane that a step has flagged: an outcome, or RUNNING with a shorter step set up."""
    room = room_of(block, lane, constants)
    sane = is_sane(block, lane, room, limits)
    tried = block[STEP * LANES + lane]
    if book[lane, TRIES] == 0:
        book[lane, REMAINING], book[lane, CLOCK], book[lane, SPAN] = block[LEFT * LANES + lane], 0.0, tried
        if sane and room > 0:
            book[lane, CLOCK] = tried
            return OUTSIDE if block[COS * LANES + lane] <= limits[LEAST_COS] else AFLOAT
    if sane and abs(room) <= limits[TOLERANCE]:
        book[lane, CLOCK] += tried
        return GROUNDED
    if sane and room > 0:
        book[lane, CLOCK] += tried
        book[lane, SPAN] -= tried
        book[lane, LOW] = room
    else:
        book[lane, SPAN] = tried
        book[lane, HIGH] = room if sane else np.nan
        restore(block, lane)
        book[lane, LOW] = room_of(block, lane, constants)
    return shorten(block, lane, book, limits)


@jit
def board(block: "Array", lane: int, book: "Array", vessel: int, start: "Array", pace: "Array", steps: "Array") -> None:
    for field in range(STATE_FIELDS):
        block[field * LANES + lane] = start[vessel, field]
        block[(OLD + field) * LANES + lane] = start[vessel, field]
    block[STEP * LANES + lane] = pace[vessel]
    block[LEFT * LANES + lane] = steps[vessel]
    book[lane, STEPS], book[lane, TRIES] = steps[vessel], 0


@jit
def park(block: "Array", lane: int) -> None:
    """Leave an empty lane on the centreline, with steps of no length."""
    for field in (Y, SIN, V, R, STEP):
        block[field * LANES + lane] = 0
    block[COS * LANES + lane] = 1
    block[LEFT * LANES + lane] = np.inf


@jit
def arrive(block: "Array", lane: int, book: "Array", vessel: int, end: "Array", fate: int, codes: "Array") -> int:
    """Write where a voyage ended and how; return the whole steps before its last."""
    for field in range(STATE_FIELDS):
        end[vessel, field] = block[field * LANES + lane]
    steps = int(book[lane, STEPS] - book[lane, REMAINING])
    codes[vessel, OUTCOME], codes[vessel, COUNT] = fate, steps
    return steps - 1


@jit
def side_of(block: "Array", lane: int, fate: int, constants: "Any") -> int:
    if fate != GROUNDED:
        return 0
    y, cosine, sine = block[Y * LANES + lane], block[COS * LANES + lane], block[SIN * LANES + lane]
    leaning = lean(y, cosine, sine, *constants)
    return (leaning > 0) - (leaning < 0)


@jit
def next_of(queue: int, codes: "Array") -> int:
    while queue < len(codes) and codes[queue, OUTCOME] != RUNNING:
        queue += 1
    return queue


@jit
def aligned(memory: "Array") -> "Array":
    """The part that starts with a cache line: a vector that straddles two costs twice."""
    first = -(memory.ctypes.data // memory.itemsize) % CACHE_LINE
    return memory[first : first + FIELDS * LANES]


@cached
def fleet(
    start: "Array", pace: "Array", steps: "Array", constants: "Array", limits: "Array",
    end: "Array", time: "Array", codes: "Array",
) -> int:  # fmt: skip
    """Sail every vessel whose outcome is RUNNING to her end; return the lane-steps that it took."""
    block, book = aligned(np.zeros((FIELDS + 1) * LANES, real)), np.zeros((LANES, COLUMNS))
    who, shared = np.empty(LANES, np.int64), uniform(constants)
    active, lane_steps, queue = 0, 0, next_of(np.int64(0), codes)  # type: ignore[arg-type]
    for lane in range(LANES):
        who[lane] = -1
        park(block, lane)
        block[FLAG * LANES + lane] = 1
    flagged = True
    while True:
        for lane in range(LANES if flagged else 0):
            if block[FLAG * LANES + lane] == 0:
                continue
            vessel = who[lane]
            if vessel >= 0:
                own = of_lane(block, lane, shared)
                fate = attend(block, lane, book, limits, own)
                if fate == RUNNING:
                    continue
                whole = arrive(block, lane, book, vessel, end, fate, codes)
                time[vessel] = whole * pace[vessel] + book[lane, CLOCK]
                codes[vessel, SIDE] = side_of(block, lane, fate, own)
                who[lane], active = -1, active - 1
                park(block, lane)
            if queue < len(codes):
                who[lane], active = queue, active + 1
                board(block, lane, book, queue, start, pace, steps)
                take_constants(block, lane, constants, queue)
                queue = next_of(queue + 1, codes)
        if active == 0:
            return lane_steps
        flagged = step(block, limits, shared)
        lane_steps += LANES
