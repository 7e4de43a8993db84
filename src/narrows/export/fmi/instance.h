/*
 * A ship as an FMU has it: every variable is a number of one array, and its place there is its value reference.
 * fmi2.c and fmi3.c are the interface; choices.h is what depends on the model.
 */
#include "ship.h"
#include "choices.h"

enum {
    TIME, X, Y, PSI, U, V, R, GEAR,
    DER = GEAR + GEARED,
    CLEARANCE = DER + 6 + GEARED,
    AGROUND = CLEARANCE + 2 * BANKS, OUTCOME, SIDE, OUTCOME_TIME, BEYOND, SETTABLE, STEP = SETTABLE, INPUTS,
    PARAMETERS = INPUTS + sizeof(ship_inputs) / sizeof(double),
    INDICATORS = PARAMETERS + sizeof(ship_parameters) / sizeof(double),
    COUNT = INDICATORS + EVENTS
};
enum { STATES = 6 + GEARED, GEAR_AT = SHIP_STATES - GEARED };

static const double TOUCHED = 1e-6; /* [m] clearance at which an importer's event is taken for a contact */
typedef struct {
    double value[COUNT], state[SHIP_NUMBERS], stop;
    ship_constants constants;
    int mode, stale, parameters_stale; /* whether values were set since rates, and since constants, were computed */
    int pending, side;                 /* how the voyage has ended where the importer has not handled it yet; to which side */
} Numbers;

#include "calls.h"

static void inputs_of(const double *value, ship_inputs *inputs) { memcpy(inputs, value + INPUTS, sizeof *inputs); }

/* A number goes into the state that is sailed. */
static void put(Numbers *n, unsigned place, double value) {
    n->value[place] = value;
    if (place == X || place == Y) n->state[place - X] = value;
    if (place >= U && place <= R) n->state[4 + place - U] = value;
    if (place == PSI) n->state[2] = cos(value), n->state[3] = sin(value);
    if (place == PSI && COUNTED) n->state[7] = value;
    if (place >= GEAR && place < DER) n->state[GEAR_AT + place - GEAR] = value;
    if (place >= PARAMETERS && place < INDICATORS) n->parameters_stale = 1;
    n->stale = 1;
}

static void reset(Instance *m) {
    Numbers *n = &m->now;
    const ship_inputs inputs = ship_at_rest;
    memset(n, 0, sizeof *n);
    memcpy(n->value + PARAMETERS, &ship_model, sizeof ship_model);
    memcpy(n->value + INPUTS, &inputs, sizeof inputs);
    n->value[STEP] = STEP_LENGTH;
    n->state[2] = 1.0, n->parameters_stale = 1, n->mode = MADE;
    n->stop = INFINITY;
    put(n, U, SPEED);
}

/* Rates, clearance and event indicators of the state as it is. */
static void refresh(Instance *m) {
    Numbers *n = &m->now;
    double *w = n->value;
    if (!n->stale) return;
    if (n->parameters_stale) {
        ship_parameters parameters;
        memcpy(&parameters, w + PARAMETERS, sizeof parameters);
        ship_prepare(&parameters, &n->constants);
        n->parameters_stale = 0;
    }
    ship_inputs inputs;
    inputs_of(w, &inputs);
    evaluate(n->state, &inputs, &n->constants, w[STEP], w + DER);
    if (w[OUTCOME] != SHIP_AFLOAT) memset(w + DER, 0, STATES * sizeof(double));
    indicate(n->state, &n->constants, w + CLEARANCE, w + INDICATORS);
    if (w[OUTCOME] != SHIP_AFLOAT)
        for (int i = 0; i < EVENTS; ++i) w[INDICATORS + i] = -1.0;
    n->stale = 0;
}
/* The ship lies still from now on: how its voyage ended, where and when. */
static void end_voyage(Instance *m, int outcome, double side, double time) {
    Numbers *n = &m->now;
    n->value[OUTCOME] = outcome, n->value[OUTCOME_TIME] = time, n->pending = SHIP_AFLOAT;
    n->value[AGROUND] = outcome == SHIP_GROUNDED;
    n->value[SIDE] = outcome == SHIP_GROUNDED ? (side > 0.0) - (side < 0.0) : 0.0;
    for (unsigned place = U; place <= R; ++place) put(n, place, 0.0);
}

/* What is discrete: an end that was met, and whether the motion is beyond the data. Returns whether anything changed. */
static int update(Instance *m) {
    Numbers *n = &m->now;
    double *w = n->value;
    const double before = w[BEYOND], outcome = w[OUTCOME];
    refresh(m);
    w[BEYOND] = ship_beyond(n->state, &n->constants CANAL);
    if (outcome == SHIP_AFLOAT && n->pending != SHIP_AFLOAT) end_voyage(m, n->pending, n->side, w[TIME]);
    else if (outcome == SHIP_AFLOAT && m->exchange)
        for (int i = EVENTS - 1; i >= 0; --i)
            if (w[INDICATORS + i] < (i < 3 * BANKS ? TOUCHED : 0.0)) {
                end_voyage(m, event_outcome[i], i == 0 ? 1.0 : -1.0, w[TIME]);
                break;
            }
    return w[BEYOND] != before || w[OUTCOME] != outcome;
}

/* Whether the start is one: afloat, with finite rates. */
static int starts(Instance *m) {
    refresh(m);
    for (int i = 0; i < STATES; ++i)
        if (!isfinite(m->now.value[DER + i])) return refuse(m, "the rates at the start are no numbers: check parameters and start");
    for (int i = 0; i < EVENTS; ++i) {
        const double clearance = m->now.value[INDICATORS + i];
        if (event_outcome[i] == SHIP_GROUNDED && !(clearance > 0.0))
            return refuse_with(m, "the hull starts %g m into the bank; start nearer the centreline", -clearance);
        if (!(clearance > 0.0) && !(clearance == 0.0 && event_outcome[i] == SHIP_ASTERN))
            return refuse(m, "the ship starts across the canal, or outside of the waterway");
    }
    m->now.value[BEYOND] = ship_beyond(m->now.state, &m->now.constants CANAL);
    return 1;
}

/* The pose of the state as its variables; the heading goes on counting turns. */
static void show(Numbers *n, double cosine, double sine) {
    double *w = n->value, *z = n->state;
    w[PSI] = COUNTED ? z[7] : w[PSI] + atan2(z[3] * cosine - z[2] * sine, z[2] * cosine + z[3] * sine);
    w[X] = z[0], w[Y] = z[1], w[U] = z[4], w[V] = z[5], w[R] = z[6];
    for (int i = 0; i < GEARED; ++i) w[GEAR + i] = z[GEAR_AT + i];
    n->stale = 1;
}

/* Sail for so long, as the importer counts; 0 where that is no step or the numbers run out. Returns early where it may. */
static int integrate(Instance *m, double time, double duration, double *reached) {
    Numbers *n = &m->now;
    double *w = n->value, end[2];
    *reached = w[TIME];
    if (!may_step(m, time, duration)) return 0;
    if (n->pending != SHIP_AFLOAT) update(m);
    refresh(m);
    *reached = w[TIME] = time + duration;
    if (w[OUTCOME] != SHIP_AFLOAT) return 1;
    const double cosine = n->state[2], sine = n->state[3];
    ship_inputs inputs;
    inputs_of(w, &inputs);
    const int outcome = ship_integrate(n->state, &inputs, &n->constants CANAL, fmin(w[STEP], duration), duration, end);
    if (outcome == SHIP_REFUSED) return refuse_with(m, "a step of %g s takes the ship farther than its length: shorten it", fmin(w[STEP], duration));
    show(n, cosine, sine);
    if (outcome != SHIP_AFLOAT) {
        n->pending = outcome, n->side = end[1] > 0.0 ? 1 : -1;
        if (m->early) *reached = w[TIME] = time + end[0];
        if (!m->with_events) end_voyage(m, outcome, end[1], time + end[0]);
        if (outcome == SHIP_DIVERGED) {
            n->mode = FAILED;
            return refuse_with(m, "after %g s the numbers diverge", end[0]);
        }
    }
    w[BEYOND] = ship_beyond(n->state, &n->constants CANAL);
    return 1;
}

static int is_beyond_changed(Instance *m) { return refresh(m), ship_beyond(m->now.state, &m->now.constants CANAL) != (int)m->now.value[BEYOND]; }
#define HAS_EVENT(m) ((m)->now.pending != SHIP_AFLOAT)
