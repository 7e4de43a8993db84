/* Fleets of one model, for a page: every ship with parameters and a step of its own, until it ends or its time is up. */
#include "lanes.c"

enum { MOST = 4096, PATHS = 1024, SAMPLES = 96, SEEN = 4, ENDS = STATES + 2 };
#define EXPORT(name) __attribute__((export_name(#name)))

static double starts[MOST][STATES + 1]; /* the state, then the length of a step [s] */
static double parameters[MOST][PARAMETERS];
static double told[INPUTS];
static double ends[MOST][ENDS];             /* the state, then time [s] and outcome */
static float paths[PATHS][SAMPLES][SEEN]; /* x, y, sine of the heading, rudder of the first ships, every so many steps */
static int kept[PATHS];
static int who[LANES], left[LANES], due[LANES];
static int each; /* whether parameters are of each ship, or the first row's for all */

EXPORT(starts) void *starts_at(void) { return starts; }
EXPORT(parameters) void *parameters_at(void) { return parameters; }
EXPORT(told) void *told_at(void) { return told; }
EXPORT(ends) void *ends_at(void) { return ends; }
EXPORT(paths) void *paths_at(void) { return paths; }
EXPORT(kept) void *kept_at(void) { return kept; }

static const double *own_parameters(int ship) { return parameters[each ? ship : 0]; }

static void keep(int lane) {
    const int ship = who[lane];
    if (ship >= PATHS || kept[ship] >= SAMPLES) return;
    float *at = paths[ship][kept[ship]++];
    at[0] = (float)now[LANE_X][lane], at[1] = (float)now[LANE_Y][lane], at[2] = (float)now[LANE_SIN_PSI][lane];
#ifdef STEERED
    at[3] = (float)now[LANE_RUDDER][lane];
#endif
}

static void board(int lane, int ship, int steps, int every) {
    who[lane] = ship, left[lane] = steps, due[lane] = every;
    if (ship < PATHS) kept[ship] = 0;
    load(lane, starts[ship], own_parameters(ship), starts[ship][STATES]);
    if (every) keep(lane);
}

static void arrive(int lane, const double *state, int steps, double time, int outcome) {
    double *end = ends[who[lane]];
    for (int j = 0; j < STATES; ++j) end[j] = state[j];
    end[STATES] = time + (steps - left[lane] - 1) * starts[who[lane]][STATES], end[STATES + 1] = outcome;
}

/* Look at a lane after a step; whether its voyage is over. */
static int over(int lane, int steps, int every) {
    const double step = starts[who[lane]][STATES];
    double state[LANE_NUMBERS], end[2] = {step, 0};
    int outcome = SHIP_AFLOAT;
    if (stop[lane] > 0) {
        outcome = judged(lane, own_parameters(who[lane]), step, state, end);
        /* By a hair, to the coarser eye of the lanes alone. */
        if (outcome == SHIP_AFLOAT) for (int j = 0; j < STATES; ++j) now[j][lane] = (real)state[j];
    } else for (int j = 0; j < STATES; ++j) state[j] = now[j][lane];
    if (outcome == SHIP_AFLOAT && left[lane] > 0) {
        if (every && due[lane] == 0) due[lane] = every, keep(lane);
        return 0;
    }
    arrive(lane, state, steps, end[0], outcome);
    return 1;
}

/* Steps that may be taken before any lane has to be looked at. */
static int clear_steps(int every) {
    int least = 1 << 30;
    for (int lane = 0; lane < LANES; ++lane) {
        if (who[lane] < 0) continue;
        const int next = every && who[lane] < PATHS && due[lane] < left[lane] ? due[lane] : left[lane];
        least = next < least ? next : least;
    }
    return least;
}

/* March until a lane wants attention. */
static void until_due(int every) {
    const int most = clear_steps(every);
    int taken = 0;
    for (int flagged = 0; taken < most && !flagged; ++taken) flagged = march();
    for (int lane = 0; lane < LANES; ++lane) left[lane] -= taken, due[lane] -= taken;
}

/* Sail ships in at most so many steps, keeping a point of the path every so many (0: none). */
EXPORT(integrate) void integrate(int ships, int steps, int every, int of_each) {
    int next = 0, active = 0;
    each = of_each;
    for (int j = 0; j < INPUTS; ++j) ((real *)&lane_told)[j] = (real)(((double *)&ship_told)[j] = told[j]);
    for (int lane = 0; lane < LANES; ++lane) idle(lane, parameters[0]), who[lane] = -1;
    for (int lane = 0; lane < LANES && next < ships; ++lane, ++active) board(lane, next++, steps, every);
    while (active) {
        until_due(every);
        for (int lane = 0; lane < LANES; ++lane) {
            if (who[lane] < 0 || !over(lane, steps, every)) continue;
            if (next < ships) board(lane, next++, steps, every);
            else idle(lane, parameters[0]), who[lane] = -1, --active;
        }
    }
}
