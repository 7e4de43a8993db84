/* A ship as an FMU has it: every variable is a number of one array, and its place there is its value reference. */
#include <stdlib.h>
#include <string.h>

#include "ship.h"
#include "choices.h" /* TOKEN, SPEED, STEP_LENGTH, CANAL, GEARED, hold_gear, column_of_input */

enum {
    TIME, X, Y, PSI, U, V, R, DER_X, DER_Y, DER_PSI, DER_U, DER_V, DER_R, STARBOARD, PORT, AGROUND, STEP, GEAR,
    INPUTS = GEAR + GEARED,
    PARAMETERS = INPUTS + sizeof(ship_inputs) / sizeof(double),
    INDICATORS = PARAMETERS + sizeof(ship_parameters) / sizeof(double),
    COUNT = INDICATORS + 2
};
enum { STATES = 6, MODEL_EXCHANGE = 0 };
static const double TOUCHED = 1e-6; /* [m] room at which an importer's event is taken for a contact */

typedef struct {
    double value[COUNT], state[SHIP_NUMBERS];
    ship_constants constants;
    int stale, exchange; /* whether a value was set since rates were computed; whether this is model exchange */
    void (*tell)(void *whom, const char *sentence, double number);
    void *whom;
} Instance;

static ship_inputs inputs_of(const Instance *m) {
    ship_inputs inputs;
    memcpy(&inputs, m->value + INPUTS, sizeof inputs);
    return inputs;
}

/* The pose of the state as its variables; the heading goes on counting turns. */
static void show(Instance *m, double cosine, double sine) {
    double *w = m->value, *z = m->state;
    w[PSI] += atan2(z[3] * cosine - z[2] * sine, z[2] * cosine + z[3] * sine);
    w[X] = z[0], w[Y] = z[1], w[U] = z[4], w[V] = z[5], w[R] = z[6];
    for (int i = 0; i < GEARED; ++i) w[GEAR + i] = z[7 + i];
    m->stale = 1;
}

static void set(Instance *m, unsigned place, double value) {
    m->value[place] = value;
    if (place == X || place == Y) m->state[place - X] = value;
    if (place >= U && place <= R) m->state[4 + place - U] = value;
    if (place == PSI) m->state[2] = cos(value), m->state[3] = sin(value);
    if (place >= GEAR && place < INPUTS) m->state[7 + place - GEAR] = value;
    m->stale = 1;
}

static void reset(Instance *m) {
    const ship_inputs inputs = ship_at_rest;
    memset(m->value, 0, sizeof m->value);
    memset(m->state, 0, sizeof m->state);
    memcpy(m->value + PARAMETERS, &ship_model, sizeof ship_model);
    memcpy(m->value + INPUTS, &inputs, sizeof inputs);
    m->value[STEP] = STEP_LENGTH;
    m->state[2] = 1.0;
    set(m, U, SPEED);
}

static void refresh(Instance *m) {
    if (!m->stale) return;
    double rate[SHIP_STATES], *w = m->value, *z = m->state;
    ship_parameters parameters;
    memcpy(&parameters, w + PARAMETERS, sizeof parameters);
    ship_prepare(&parameters, &m->constants);
    const ship_inputs inputs = inputs_of(m);
    if (m->exchange) hold_gear(z, &inputs, &m->constants);
    for (int i = 0; i < GEARED; ++i) w[GEAR + i] = z[7 + i];
    ship_rates(z, &inputs, &m->constants CANAL, rate);
    w[DER_X] = rate[0], w[DER_Y] = rate[1], w[DER_PSI] = z[2] * rate[3] - z[3] * rate[2];
    w[DER_U] = rate[4], w[DER_V] = rate[5], w[DER_R] = rate[6];
    if (w[AGROUND] != 0.0) memset(w + DER_X, 0, STATES * sizeof(double));
    ship_clearance(z, w + STARBOARD, CLEARANCE_OF);
    for (int i = 0; i < 2; ++i) w[INDICATORS + i] = w[AGROUND] != 0.0 ? -1.0 : w[STARBOARD + i];
    m->stale = 0;
}

static double get(Instance *m, unsigned place) { return refresh(m), m->value[place]; }
static double room(Instance *m) { return refresh(m), fmin(m->value[STARBOARD], m->value[PORT]); }

/* Whether the hull has just touched a bank; from then on the ship lies still. */
static int touches(Instance *m) {
    if (m->value[AGROUND] != 0.0 || room(m) > TOUCHED) return 0;
    m->value[AGROUND] = 1.0, m->stale = 1;
    return 1;
}

static int starts_afloat(Instance *m) {
    if (room(m) > 0.0) return 1;
    m->tell(m->whom, "the hull starts %g m into the bank; start nearer the centreline", -room(m));
    return 0;
}

/* Sail for so long; returns 0 where a heading lies across the canal, the waterway ends, or numbers run out. */
static int sail(Instance *m, double duration) {
    refresh(m);
    m->value[TIME] += duration;
    if (m->value[AGROUND] != 0.0 || !(duration > 0.0)) return 1;
    const double cosine = m->state[2], sine = m->state[3];
    const ship_inputs inputs = inputs_of(m);
    double end[2];
    const int fate = ship_sail(m->state, &inputs, &m->constants CANAL, fmin(m->value[STEP], duration), duration, end);
    show(m, cosine, sine);
    if (fate == SHIP_GROUNDED) m->value[AGROUND] = 1.0;
    if (fate == SHIP_AFLOAT || fate == SHIP_GROUNDED) return 1;
    m->tell(m->whom, "after %g s the ship lies across the canal, leaves the waterway, or moves as none does", end[0]);
    return 0;
}

/* The exact derivative of an unknown by a known. */
static double slope(Instance *m, unsigned unknown, unsigned known) {
    double by_state[36], by_input[6 * CONTROLS];
    const ship_inputs inputs = inputs_of(m);
    if (unknown >= X && unknown <= R) return unknown == known;
    if (unknown < DER_X || unknown > DER_R) return 0.0;
    if (refresh(m), m->value[AGROUND] != 0.0) return 0.0;
    if (known >= X && known <= R) {
        ship_by_state(m->state, &inputs, &m->constants CANAL, by_state);
        return by_state[6 * (unknown - DER_X) + known - X];
    }
    const int column = known >= INPUTS && known < PARAMETERS ? column_of_input[known - INPUTS] : -1;
    if (column < 0) return 0.0;
    ship_by_input(m->state, &inputs, &m->constants CANAL, by_input);
    return by_input[CONTROLS * (unknown - DER_X) + column];
}

/* Take over another's numbers; to whom it speaks stays. */
static void restore(Instance *m, const Instance *from) {
    void *whom = m->whom;
    void (*speak)(void *, const char *, double) = m->tell;
    memcpy(m, from, sizeof *m);
    m->whom = whom, m->tell = speak;
}
