/* The interface of FMI 3.0, model exchange and co-simulation, to a ship (instance.h). */
#include "instance.h"
#include "fmi3Functions.h"

#define EXPORT FMI3_Export
#define EACH(n) for (size_t i = 0; i < (n); ++i)
#define MAY(modes) do { if (!may(c, modes)) return fmi3Error; } while (0)
typedef fmi3Status S;
typedef fmi3Instance C;
typedef fmi3ValueReference Ref;
typedef struct {
    Instance ship;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Component;

static void tell(void *whom, const char *sentence) {
    const Component *c = whom;
    if (c->log) c->log(c->environment, fmi3Error, "logStatusError", sentence);
}
static Numbers *numbers(C c) { return &((Instance *)c)->now; }
static S status(int right) { return right ? fmi3OK : fmi3Error; }
static S none(C c, size_t n) { return n ? status(refuse(c, "there is no variable of this type, or it cannot be set")) : fmi3OK; }
static S moved(C c, int from, int to) { return may(c, from) ? (numbers(c)->mode = to, fmi3OK) : fmi3Error; }
static Component *made(fmi3String token, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    if (!token || strcmp(token, TOKEN)) return NULL;
    Component *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->log = log, c->environment = environment, c->ship.tell = tell, c->ship.whom = c;
    reset(&c->ship);
    return c;
}

EXPORT const char *fmi3GetVersion(void) { return fmi3Version; }
EXPORT S fmi3SetDebugLogging(C c, fmi3Boolean on, size_t n, const fmi3String which[]) { return (void)c, (void)on, (void)n, (void)which, fmi3OK; }
EXPORT C fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible, fmi3Boolean logging,
                                      fmi3InstanceEnvironment e, fmi3LogMessageCallback l) {
    (void)name, (void)place, (void)visible, (void)logging;
    Component *c = made(token, e, l);
    if (c) c->ship.exchange = 1;
    return c;
}
EXPORT C fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible, fmi3Boolean logging,
                                     fmi3Boolean events, fmi3Boolean early, const Ref need[], size_t n, fmi3InstanceEnvironment e,
                                     fmi3LogMessageCallback l, fmi3IntermediateUpdateCallback u) {
    (void)name, (void)place, (void)visible, (void)logging, (void)need, (void)n, (void)u;
    Component *c = made(token, e, l);
    if (c) c->ship.with_events = events, c->ship.early = early;
    return c;
}
EXPORT C fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible, fmi3Boolean logging,
                                           fmi3InstanceEnvironment e, fmi3LogMessageCallback l, fmi3ClockUpdateCallback u,
                                           fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)place, (void)visible, (void)logging, (void)e, (void)l, (void)u, (void)lock, (void)unlock;
    return NULL;
}
EXPORT void fmi3FreeInstance(C c) { free(c); }
EXPORT S fmi3EnterInitializationMode(C c, fmi3Boolean t, fmi3Float64 tol, fmi3Float64 start, fmi3Boolean s, fmi3Float64 stop) {
    (void)t, (void)tol;
    MAY(MADE);
    if (!isfinite(start) || (s && !(stop > start))) return status(refuse(c, "the experiment has no time: start and stop must rise"));
    numbers(c)->value[TIME] = start, numbers(c)->stop = s ? stop : INFINITY;
    return moved(c, MADE, STARTING);
}
EXPORT S fmi3ExitInitializationMode(C c) {
    const Instance *m = c;
    MAY(STARTING);
    return starts(c) ? moved(c, STARTING, m->exchange || m->with_events ? EVENT : STEPPING) : fmi3Error;
}
EXPORT S fmi3EnterEventMode(C c) { return moved(c, EVENT | CONTINUOUS | STEPPING, EVENT); }
EXPORT S fmi3Terminate(C c) { return moved(c, RUNNING, ENDED); }
EXPORT S fmi3Reset(C c) { return reset(c), fmi3OK; }

#define GET(T, KINDS_OF) \
    EXPORT S fmi3Get##T(C c, const Ref r[], size_t n, fmi3##T v[], size_t nv) { \
        if (n != nv) return fmi3Error; \
        EACH(n) { if (!may_get(c, r[i], KINDS_OF)) return fmi3Error; v[i] = (fmi3##T)get(c, r[i]); } \
        return fmi3OK; \
    }
GET(Float64, REALS) GET(Int32, INTEGERS)
EXPORT S fmi3GetBoolean(C c, const Ref r[], size_t n, fmi3Boolean v[], size_t nv) {
    if (n != nv) return fmi3Error;
    EACH(n) { if (!may_get(c, r[i], TRUTHS)) return fmi3Error; v[i] = get(c, r[i]) != 0.0; }
    return fmi3OK;
}
EXPORT S fmi3SetFloat64(C c, const Ref r[], size_t n, const fmi3Float64 v[], size_t nv) {
    if (n != nv) return fmi3Error;
    EACH(n) if (!assign(c, r[i], v[i])) return fmi3Error;
    return fmi3OK;
}
#define NO_GET(T) EXPORT S fmi3Get##T(C c, const Ref r[], size_t n, fmi3##T v[], size_t nv) { return (void)r, (void)v, (void)nv, none(c, n); }
#define NO_SET(T) EXPORT S fmi3Set##T(C c, const Ref r[], size_t n, const fmi3##T v[], size_t nv) { return (void)r, (void)v, (void)nv, none(c, n); }
NO_GET(Float32) NO_GET(Int8) NO_GET(UInt8) NO_GET(Int16) NO_GET(UInt16) NO_GET(UInt32) NO_GET(Int64) NO_GET(UInt64) NO_GET(String)
NO_SET(Float32) NO_SET(Int8) NO_SET(UInt8) NO_SET(Int16) NO_SET(UInt16) NO_SET(Int32) NO_SET(UInt32) NO_SET(Int64) NO_SET(UInt64)
NO_SET(String) NO_SET(Boolean)
EXPORT S fmi3GetBinary(C c, const Ref r[], size_t n, size_t s[], fmi3Binary v[], size_t nv) { return (void)r, (void)s, (void)v, (void)nv, none(c, n); }
EXPORT S fmi3SetBinary(C c, const Ref r[], size_t n, const size_t s[], const fmi3Binary v[], size_t nv) { return (void)r, (void)s, (void)v, (void)nv, none(c, n); }
EXPORT S fmi3GetClock(C c, const Ref r[], size_t n, fmi3Clock v[]) { return (void)r, (void)v, none(c, n); }
EXPORT S fmi3SetClock(C c, const Ref r[], size_t n, const fmi3Clock v[]) { return (void)r, (void)v, none(c, n); }

EXPORT S fmi3GetNumberOfVariableDependencies(C c, Ref r, size_t *n) { return (void)r, (void)n, none(c, 1); }
EXPORT S fmi3GetVariableDependencies(C c, Ref r, size_t a[], Ref b[], size_t d[], fmi3DependencyKind k[], size_t n) { return (void)r, (void)a, (void)b, (void)d, (void)k, (void)n, none(c, 1); }

/* All of a ship is numbers, so its state is a copy of them. */
EXPORT S fmi3GetFMUState(C c, fmi3FMUState *s) {
    if (!*s) *s = malloc(sizeof(Numbers));
    return *s ? (memcpy(*s, numbers(c), sizeof(Numbers)), fmi3OK) : fmi3Error;
}
EXPORT S fmi3SetFMUState(C c, fmi3FMUState s) { return s ? (memcpy(numbers(c), s, sizeof(Numbers)), fmi3OK) : fmi3Error; }
EXPORT S fmi3FreeFMUState(C c, fmi3FMUState *s) { return (void)c, free(*s), *s = NULL, fmi3OK; }
EXPORT S fmi3SerializedFMUStateSize(C c, fmi3FMUState s, size_t *n) { return (void)c, (void)s, *n = sizeof(Numbers), fmi3OK; }
EXPORT S fmi3SerializeFMUState(C c, fmi3FMUState s, fmi3Byte to[], size_t n) {
    (void)c;
    return !s || n < sizeof(Numbers) ? fmi3Error : (memcpy(to, s, sizeof(Numbers)), fmi3OK);
}
EXPORT S fmi3DeserializeFMUState(C c, const fmi3Byte from[], size_t n, fmi3FMUState *s) {
    if (n != sizeof(Numbers) || fmi3GetFMUState(c, s) != fmi3OK) return fmi3Error;
    return memcpy(*s, from, sizeof(Numbers)), fmi3OK;
}
EXPORT S fmi3GetDirectionalDerivative(C c, const Ref u[], size_t nu, const Ref k[], size_t nk, const fmi3Float64 seed[], size_t ns, fmi3Float64 du[], size_t nd) {
    (void)u, (void)nu, (void)k, (void)nk, (void)seed, (void)ns, (void)du, (void)nd;
    return status(refuse(c, "this FMU gives no derivatives"));
}
EXPORT S fmi3GetAdjointDerivative(C c, const Ref u[], size_t nu, const Ref k[], size_t nk, const fmi3Float64 seed[], size_t ns, fmi3Float64 dk[], size_t nd) {
    return fmi3GetDirectionalDerivative(c, u, nu, k, nk, seed, ns, dk, nd);
}

static S no_clock(C c) { return status(refuse(c, "there are no clocks and no structural parameters")); }
EXPORT S fmi3EnterConfigurationMode(C c) { return no_clock(c); }
EXPORT S fmi3ExitConfigurationMode(C c) { return no_clock(c); }
EXPORT S fmi3GetIntervalDecimal(C c, const Ref r[], size_t n, fmi3Float64 v[], fmi3IntervalQualifier q[]) { return (void)r, (void)n, (void)v, (void)q, no_clock(c); }
EXPORT S fmi3GetIntervalFraction(C c, const Ref r[], size_t n, fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier q[]) { return (void)r, (void)n, (void)a, (void)b, (void)q, no_clock(c); }
EXPORT S fmi3GetShiftDecimal(C c, const Ref r[], size_t n, fmi3Float64 v[]) { return (void)r, (void)n, (void)v, no_clock(c); }
EXPORT S fmi3GetShiftFraction(C c, const Ref r[], size_t n, fmi3UInt64 a[], fmi3UInt64 b[]) { return (void)r, (void)n, (void)a, (void)b, no_clock(c); }
EXPORT S fmi3SetIntervalDecimal(C c, const Ref r[], size_t n, const fmi3Float64 v[]) { return (void)r, (void)n, (void)v, no_clock(c); }
EXPORT S fmi3SetIntervalFraction(C c, const Ref r[], size_t n, const fmi3UInt64 a[], const fmi3UInt64 b[]) { return (void)r, (void)n, (void)a, (void)b, no_clock(c); }
EXPORT S fmi3SetShiftDecimal(C c, const Ref r[], size_t n, const fmi3Float64 v[]) { return (void)r, (void)n, (void)v, no_clock(c); }
EXPORT S fmi3SetShiftFraction(C c, const Ref r[], size_t n, const fmi3UInt64 a[], const fmi3UInt64 b[]) { return (void)r, (void)n, (void)a, (void)b, no_clock(c); }
EXPORT S fmi3ActivateModelPartition(C c, Ref r, fmi3Float64 t) { return (void)r, (void)t, no_clock(c); }
EXPORT S fmi3EvaluateDiscreteStates(C c) { MAY(STARTING | EVENT); return fmi3OK; }
EXPORT S fmi3UpdateDiscreteStates(C c, fmi3Boolean *again, fmi3Boolean *stop, fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    MAY(EVENT);
    *again = *stop = *nominals = *defined = fmi3False, *next = 0.0;
    *values = update(c);
    return fmi3OK;
}

EXPORT S fmi3EnterContinuousTimeMode(C c) { return moved(c, EVENT, CONTINUOUS); }
EXPORT S fmi3CompletedIntegratorStep(C c, fmi3Boolean n, fmi3Boolean *enter, fmi3Boolean *stop) {
    (void)n;
    MAY(CONTINUOUS);
    *enter = is_beyond_changed(c), *stop = fmi3False;
    return fmi3OK;
}
EXPORT S fmi3SetTime(C c, fmi3Float64 t) {
    MAY(EVENT | CONTINUOUS);
    if (!isfinite(t)) return status(refuse(c, "the time is no number"));
    return numbers(c)->value[TIME] = t, fmi3OK;
}
EXPORT S fmi3SetContinuousStates(C c, const fmi3Float64 x[], size_t n) {
    MAY(CONTINUOUS);
    if (n != STATES) return fmi3Error;
    EACH(n) if (!isfinite(x[i])) return status(refuse(c, "a state is no number"));
    EACH(n) put(numbers(c), X + (unsigned)i, x[i]);
    return fmi3OK;
}
#define VECTOR(NAME, FIRST, SIZE) \
    EXPORT S fmi3Get##NAME(C c, fmi3Float64 v[], size_t n) { \
        MAY(STARTING | EVENT | CONTINUOUS | ENDED); \
        if (n != (SIZE)) return fmi3Error; \
        EACH(n) v[i] = get(c, (FIRST) + (unsigned)i); \
        return fmi3OK; \
    }
VECTOR(ContinuousStateDerivatives, DER, STATES)
VECTOR(EventIndicators, INDICATORS, EVENTS)
VECTOR(ContinuousStates, X, STATES)
EXPORT S fmi3GetNominalsOfContinuousStates(C c, fmi3Float64 x[], size_t n) { EACH(n) x[i] = 1; return (void)c, fmi3OK; }
EXPORT S fmi3GetNumberOfEventIndicators(C c, size_t *n) { return (void)c, *n = EVENTS, fmi3OK; }
EXPORT S fmi3GetNumberOfContinuousStates(C c, size_t *n) { return (void)c, *n = STATES, fmi3OK; }

EXPORT S fmi3EnterStepMode(C c) { return moved(c, EVENT, STEPPING); }
EXPORT S fmi3GetOutputDerivatives(C c, const Ref r[], size_t n, const fmi3Int32 o[], fmi3Float64 v[], size_t nv) { return (void)r, (void)o, (void)v, (void)nv, none(c, n); }
EXPORT S fmi3DoStep(C c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean n, fmi3Boolean *event, fmi3Boolean *stop, fmi3Boolean *early, fmi3Float64 *last) {
    (void)n;
    *event = *stop = *early = fmi3False, *last = t;
    MAY(STEPPING);
    const S done = status(integrate(c, t, h, last));
    *event = ((Instance *)c)->with_events && HAS_EVENT((Instance *)c);
    *early = *last < t + h && done == fmi3OK;
    return done;
}
