/*
 * Sixty-four ships side by side, each with constants and a step of its own.
 *
 * `lane_` is the exported model in the precision of the lanes, `ship_` the same in double precision.
 */
#include "lane.h"
#include "ship.h"

typedef LANE_REAL real;
enum { LANES = 64, STATES = LANE_STATES, PARAMETERS = sizeof(lane_parameters) / sizeof(real),
       INPUTS = sizeof(lane_inputs) / sizeof(real), CONSTANTS = sizeof(lane_constants) / sizeof(real) };
/* Else an array of many constants stays in memory, and the loop over lanes scalar. */
#define UNROLLED _Pragma("clang loop unroll(full)")

typedef real row[LANES];
typedef unsigned long long __attribute__((may_alias)) bits;
static row now[STATES], before[STATES], constant[CONSTANTS], pace, stop, lost;
static lane_inputs lane_told;
static ship_inputs ship_told;

/* One step of every lane; whether any has no room left, or is faster than any ship. */
static int march(void) {
#pragma clang loop vectorize(enable)
    for (int lane = 0; lane < LANES; ++lane) {
        real state[LANE_NUMBERS];
        lane_constants own;
        real *k = (real *)&own;
        UNROLLED for (int j = 0; j < CONSTANTS; ++j) k[j] = constant[j][lane];
        UNROLLED for (int j = 0; j < STATES; ++j) before[j][lane] = state[j] = now[j][lane];
        /* The canal is straight: a step from x = 0 is as far as it comes, and is added with what rounding lost (Kahan). */
        state[LANE_X] = 0;
        lane_step(state, state, pace[lane], &lane_told, &own);
        const real more = state[LANE_X] - lost[lane], sum = before[LANE_X][lane] + more;
        lost[lane] = (sum - before[LANE_X][lane]) - more, state[LANE_X] = sum;
        UNROLLED for (int j = 0; j < STATES; ++j) now[j][lane] = state[j];
        const int slow = (fabs(state[LANE_U]) < LANE_MOST_SPEED) & (fabs(state[LANE_V]) < LANE_MOST_SPEED);
        stop[lane] = slow & (fabs(state[LANE_R]) < LANE_MOST_RATE) & (state[LANE_STATES] > 0) ? (real)0 : (real)1;
    }
    /* Bits, not a sum of flags: that would stop the loop from vectorising. */
    bits any = 0;
    for (unsigned i = 0; i < sizeof stop / sizeof any; ++i) any |= ((const bits *)(const void *)stop)[i];
    return any != 0;
}

/* A lane at the start of a voyage. */
static void load(int lane, const double *state, const double *parameters, double step) {
    lane_parameters own;
    lane_constants made;
    for (int j = 0; j < PARAMETERS; ++j) ((real *)&own)[j] = (real)parameters[j];
    lane_prepare(&own, &made);
    for (int j = 0; j < CONSTANTS; ++j) constant[j][lane] = ((const real *)&made)[j];
    for (int j = 0; j < STATES; ++j) now[j][lane] = before[j][lane] = (real)state[j];
    pace[lane] = (real)step, lost[lane] = 0;
}

/* An idle lane stands in the middle, where nothing asks for attention. */
static void idle(int lane, const double *parameters) {
    const double state[STATES] = {[LANE_COS_PSI] = 1};
    load(lane, state, parameters, 0);
}

/* The step that a lane has just taken, by the rule of the exported model in double precision; how the ship is then. */
static int judged(int lane, const double *parameters, double step, double *state, double *end) {
    ship_constants made;
    ship_prepare((const ship_parameters *)(const void *)parameters, &made);
    for (int j = 0; j < STATES; ++j) state[j] = before[j][lane];
    return ship_integrate(state, &ship_told, &made, step, step, end);
}
