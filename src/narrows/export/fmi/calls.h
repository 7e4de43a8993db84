/* Which calls an FMU accepts and when, and how it refuses; included where its ``Numbers`` are declared. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What an importer has done so far; functions say in which of these they may be called. */
enum { MADE = 1, STARTING = 2, EVENT = 4, CONTINUOUS = 8, STEPPING = 16, ENDED = 32, FAILED = 64 };
enum { RUNNING = EVENT | CONTINUOUS | STEPPING, GIVEN = MADE | STARTING };

static const double SAME_TIME = 1e-9; /* share of the time by which an importer's clock may differ */

typedef struct {
    Numbers now;
    int exchange, with_events, early; /* model exchange; whether the importer has an event mode, or takes a step that ends early */
    void (*tell)(void *whom, const char *sentence);
    void *whom;
} Instance;

static int refuse(const Instance *m, const char *sentence) {
    if (m->tell) m->tell(m->whom, sentence);
    return 0;
}
static int refuse_with(const Instance *m, const char *sentence, double number) {
    char text[200];
    snprintf(text, sizeof text, sentence, number);
    return refuse(m, text);
}

/* Whether a function may be called now. */
static int may(const Instance *m, int modes) {
    if (m->now.mode & modes) return 1;
    return refuse(m, m->now.mode == FAILED ? "an earlier call failed: reset, or set a saved state"
                                           : "this function is called out of turn: see the state machine of the standard");
}

/* Brings what is computed up to date with what was set. */
static void refresh(Instance *m);
static double get(Instance *m, unsigned place) { return refresh(m), m->now.value[place]; }

/* Whether a variable of one of these kinds is there to be got, and may be now. */
static int may_get(Instance *m, unsigned place, const char *kinds) {
    if (place < COUNT && strchr(kinds, KINDS[place])) return may(m, GIVEN | RUNNING | ENDED);
    return refuse_with(m, "there is no variable %g of this type", place);
}

/* Keeps a value that an importer sets. */
static void put(Numbers *n, unsigned place, double value);
/* What an importer sets: a start value, an input or a parameter, each in its time and within its bounds. */
static int assign(Instance *m, unsigned place, double value) {
    if (place >= COUNT) return refuse_with(m, "there is no variable %g", place);
    const char kind = KINDS[place];
    const int modes = kind == STATE || kind == FIXED ? GIVEN : kind == INPUT ? GIVEN | RUNNING
                    : kind == TUNABLE ? GIVEN | EVENT | STEPPING : 0;
    if (!modes) return refuse_with(m, "variable %g is computed: it cannot be set", place);
    if (!(m->now.mode & modes)) return refuse_with(m, "variable %g cannot be set any more, or not in this mode", place);
    if (!isfinite(value)) return refuse_with(m, "variable %g is set to what is no finite number", place);
    if (place >= SETTABLE && (value < low[place - SETTABLE] || value > high[place - SETTABLE]))
        return refuse_with(m, "%g is beyond the bounds of its variable", value);
    put(&m->now, place, value);
    return 1;
}

/* Whether a step of so long, as the importer counts, is one. */
static int may_step(const Instance *m, double time, double duration) {
    const Numbers *n = &m->now;
    if (!(fabs(time - n->value[TIME]) <= SAME_TIME * (1.0 + fabs(time)))) return refuse_with(m, "the last step ended at %g s: go on from there", n->value[TIME]);
    if (!(duration > 0.0) || !isfinite(duration)) return refuse_with(m, "a step of %g s is none: give a time over 0", duration);
    if (time + duration > n->stop + SAME_TIME * (1.0 + fabs(n->stop))) return refuse_with(m, "the experiment stops at %g s", n->stop);
    return 1;
}
