/*
 * The bank's force as an FMU has it: outputs of inputs, no state. Every variable is a number of one array, and its place
 * there is its value reference. fmi2.c and fmi3.c are the interface; choices.h is what depends on the model.
 */
#include "bank.h"
#include "choices.h"

enum {
    TIME, SETTABLE, AT = SETTABLE, HEADING, AHEAD, STARBOARD, PORT, SLOPE_STARBOARD, SLOPE_PORT, DEPTH,
    SWAY_FORCE, YAW_MOMENT, DEVIATION, BEYOND = DEVIATION + DEVIATIONS, COUNT
};
enum { STATES = 0, EVENTS = 0, X = COUNT, DER = COUNT, INDICATORS = COUNT };

typedef struct {
    double value[COUNT], stop;
    int mode, stale; /* whether values were set since the force was computed */
} Numbers;

#include "calls.h"

static void put(Numbers *n, unsigned place, double value) { n->value[place] = value, n->stale = 1; }

static void reset(Instance *m) {
    memset(&m->now, 0, sizeof m->now);
    memcpy(m->now.value + SETTABLE, start, sizeof start);
    m->now.stop = INFINITY, m->now.mode = MADE, m->now.stale = 1;
}

static bank_force evaluate(const Numbers *n) {
    const double *w = n->value;
    const bank_water water = {w[STARBOARD], w[PORT], w[SLOPE_STARBOARD], w[SLOPE_PORT], w[DEPTH]};
    return bank_bank_force(w[AT], w[HEADING], w[AHEAD], &water);
}

static void refresh(Instance *m) {
    double *w = m->now.value;
    if (!m->now.stale) return;
    const bank_force force = evaluate(&m->now);
    w[SWAY_FORCE] = force.Y, w[YAW_MOMENT] = force.N;
    if (DEVIATIONS) w[DEVIATION] = force.Y_deviation, w[DEVIATION + 1] = force.N_deviation;
    /* What is discrete changes at events alone. */
    if (m->now.mode != CONTINUOUS) w[BEYOND] = force.beyond;
    m->now.stale = m->now.mode == CONTINUOUS;
}

static int update(Instance *m) { return refresh(m), 0; }

static int starts(Instance *m) {
    refresh(m);
    if (isfinite(m->now.value[SWAY_FORCE]) && isfinite(m->now.value[YAW_MOMENT])) return 1;
    return refuse(m, "the force at the start is no number: check the distances to the banks and the depth");
}

static int integrate(Instance *m, double time, double duration, double *reached) {
    *reached = m->now.value[TIME];
    if (!may_step(m, time, duration)) return 0;
    *reached = m->now.value[TIME] = time + duration;
    return 1;
}

static int is_beyond_changed(Instance *m) { return evaluate(&m->now).beyond != (int)m->now.value[BEYOND]; }
#define HAS_EVENT(m) 0
