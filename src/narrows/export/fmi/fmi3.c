/* The interface of FMI 3.0, model exchange and co-simulation, to a ship (instance.h). */
#include "fmi3Functions.h"
#include "instance.h"

#include <stdio.h>

#define EXPORT FMI3_Export
#define EACH(n) for (size_t i = 0; i < (n); ++i)
typedef fmi3Status S;
typedef fmi3Instance C;
typedef fmi3ValueReference Ref;
typedef struct {
    Instance ship;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Component;

static S ok(C c) { return (void)c, fmi3OK; }
static void tell(void *whom, const char *sentence, double number) {
    const Component *c = whom;
    char text[200];
    snprintf(text, sizeof text, sentence, number);
    if (c->log) c->log(c->environment, fmi3Error, "logStatusError", text);
}
static C made(fmi3String token, int exchange, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    if (!token || strcmp(token, TOKEN)) return NULL;
    Component *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->log = log, c->environment = environment;
    c->ship.tell = tell, c->ship.whom = c, c->ship.exchange = exchange;
    reset(&c->ship);
    return c;
}

EXPORT const char *fmi3GetVersion(void) { return fmi3Version; }
EXPORT S fmi3SetDebugLogging(C c, fmi3Boolean on, size_t n, const fmi3String which[]) { return (void)on, (void)n, (void)which, ok(c); }
EXPORT C fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible, fmi3Boolean logging,
                                      fmi3InstanceEnvironment e, fmi3LogMessageCallback l) {
    (void)name, (void)place, (void)visible, (void)logging;
    return made(token, 1, e, l);
}
EXPORT C fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible, fmi3Boolean logging,
                                     fmi3Boolean events, fmi3Boolean early, const Ref need[], size_t n, fmi3InstanceEnvironment e,
                                     fmi3LogMessageCallback l, fmi3IntermediateUpdateCallback u) {
    (void)name, (void)place, (void)visible, (void)logging, (void)events, (void)early, (void)need, (void)n, (void)u;
    return made(token, 0, e, l);
}
EXPORT C fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible, fmi3Boolean logging,
                                           fmi3InstanceEnvironment e, fmi3LogMessageCallback l, fmi3ClockUpdateCallback u,
                                           fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)place, (void)visible, (void)logging, (void)e, (void)l, (void)u, (void)lock, (void)unlock;
    return NULL;
}
EXPORT void fmi3FreeInstance(C c) { free(c); }
EXPORT S fmi3EnterInitializationMode(C c, fmi3Boolean t, fmi3Float64 tol, fmi3Float64 start, fmi3Boolean s, fmi3Float64 stop) {
    (void)t, (void)tol, (void)s, (void)stop;
    return ((Instance *)c)->value[TIME] = start, fmi3OK;
}
EXPORT S fmi3ExitInitializationMode(C c) { return starts_afloat(c) ? fmi3OK : fmi3Error; }
EXPORT S fmi3EnterEventMode(C c) { return ok(c); }
EXPORT S fmi3Terminate(C c) { return ok(c); }
EXPORT S fmi3Reset(C c) { return reset(c), fmi3OK; }

EXPORT S fmi3GetFloat64(C c, const Ref r[], size_t n, fmi3Float64 v[], size_t nv) {
    if (n != nv) return fmi3Error;
    EACH(n) { if (r[i] >= COUNT) return fmi3Error; v[i] = get(c, r[i]); }
    return fmi3OK;
}
EXPORT S fmi3SetFloat64(C c, const Ref r[], size_t n, const fmi3Float64 v[], size_t nv) {
    if (n != nv) return fmi3Error;
    EACH(n) { if (r[i] >= COUNT) return fmi3Error; set(c, r[i], v[i]); }
    return fmi3OK;
}
EXPORT S fmi3GetBoolean(C c, const Ref r[], size_t n, fmi3Boolean v[], size_t nv) {
    if (n != nv) return fmi3Error;
    EACH(n) { if (r[i] != AGROUND) return fmi3Error; v[i] = get(c, r[i]) != 0; }
    return fmi3OK;
}
#define NONE(T) \
    EXPORT S fmi3Get##T(C c, const Ref r[], size_t n, fmi3##T v[], size_t nv) { (void)c, (void)r, (void)v, (void)nv; return n ? fmi3Error : fmi3OK; } \
    EXPORT S fmi3Set##T(C c, const Ref r[], size_t n, const fmi3##T v[], size_t nv) { (void)c, (void)r, (void)v, (void)nv; return n ? fmi3Error : fmi3OK; }
NONE(Float32) NONE(Int8) NONE(UInt8) NONE(Int16) NONE(UInt16) NONE(Int32) NONE(UInt32) NONE(Int64) NONE(UInt64) NONE(String)
EXPORT S fmi3SetBoolean(C c, const Ref r[], size_t n, const fmi3Boolean v[], size_t nv) { (void)c, (void)r, (void)v, (void)nv; return n ? fmi3Error : fmi3OK; }
EXPORT S fmi3GetBinary(C c, const Ref r[], size_t n, size_t s[], fmi3Binary v[], size_t nv) { (void)c, (void)r, (void)s, (void)v, (void)nv; return n ? fmi3Error : fmi3OK; }
EXPORT S fmi3SetBinary(C c, const Ref r[], size_t n, const size_t s[], const fmi3Binary v[], size_t nv) { (void)c, (void)r, (void)s, (void)v, (void)nv; return n ? fmi3Error : fmi3OK; }
EXPORT S fmi3GetClock(C c, const Ref r[], size_t n, fmi3Clock v[]) { (void)c, (void)r, (void)v; return n ? fmi3Error : fmi3OK; }
EXPORT S fmi3SetClock(C c, const Ref r[], size_t n, const fmi3Clock v[]) { (void)c, (void)r, (void)v; return n ? fmi3Error : fmi3OK; }

EXPORT S fmi3GetNumberOfVariableDependencies(C c, Ref r, size_t *n) { (void)c, (void)r, (void)n; return fmi3Error; }
EXPORT S fmi3GetVariableDependencies(C c, Ref r, size_t a[], Ref b[], size_t d[], fmi3DependencyKind k[], size_t n) { (void)c, (void)r, (void)a, (void)b, (void)d, (void)k, (void)n; return fmi3Error; }

/* All of a ship is numbers, so its state is a copy of them. */
EXPORT S fmi3GetFMUState(C c, fmi3FMUState *s) {
    if (!*s) *s = malloc(sizeof(Instance));
    return *s ? (memcpy(*s, c, sizeof(Instance)), fmi3OK) : fmi3Error;
}
EXPORT S fmi3SetFMUState(C c, fmi3FMUState s) { return restore(c, s), fmi3OK; }
EXPORT S fmi3FreeFMUState(C c, fmi3FMUState *s) { (void)c; free(*s); *s = NULL; return fmi3OK; }
EXPORT S fmi3SerializedFMUStateSize(C c, fmi3FMUState s, size_t *n) { (void)c, (void)s; *n = sizeof(Instance); return fmi3OK; }
EXPORT S fmi3SerializeFMUState(C c, fmi3FMUState s, fmi3Byte to[], size_t n) { (void)c; return n < sizeof(Instance) ? fmi3Error : (memcpy(to, s, sizeof(Instance)), fmi3OK); }
EXPORT S fmi3DeserializeFMUState(C c, const fmi3Byte from[], size_t n, fmi3FMUState *s) {
    if (n < sizeof(Instance) || fmi3GetFMUState(c, s) != fmi3OK) return fmi3Error;
    return memcpy(*s, from, sizeof(Instance)), fmi3OK;
}
EXPORT S fmi3GetDirectionalDerivative(C c, const Ref u[], size_t nu, const Ref k[], size_t nk, const fmi3Float64 seed[], size_t ns, fmi3Float64 du[], size_t nd) {
    if (ns != nk || nd != nu) return fmi3Error;
    EACH(nu) { du[i] = 0; for (size_t j = 0; j < nk; ++j) du[i] += slope(c, u[i], k[j]) * seed[j]; }
    return fmi3OK;
}
EXPORT S fmi3GetAdjointDerivative(C c, const Ref u[], size_t nu, const Ref k[], size_t nk, const fmi3Float64 seed[], size_t ns, fmi3Float64 dk[], size_t nd) {
    if (ns != nu || nd != nk) return fmi3Error;
    EACH(nk) { dk[i] = 0; for (size_t j = 0; j < nu; ++j) dk[i] += slope(c, u[j], k[i]) * seed[j]; }
    return fmi3OK;
}

EXPORT S fmi3EnterConfigurationMode(C c) { return ok(c); }
EXPORT S fmi3ExitConfigurationMode(C c) { return ok(c); }
EXPORT S fmi3GetIntervalDecimal(C c, const Ref r[], size_t n, fmi3Float64 v[], fmi3IntervalQualifier q[]) { (void)c, (void)r, (void)n, (void)v, (void)q; return fmi3Error; }
EXPORT S fmi3GetIntervalFraction(C c, const Ref r[], size_t n, fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier q[]) { (void)c, (void)r, (void)n, (void)a, (void)b, (void)q; return fmi3Error; }
EXPORT S fmi3GetShiftDecimal(C c, const Ref r[], size_t n, fmi3Float64 v[]) { (void)c, (void)r, (void)n, (void)v; return fmi3Error; }
EXPORT S fmi3GetShiftFraction(C c, const Ref r[], size_t n, fmi3UInt64 a[], fmi3UInt64 b[]) { (void)c, (void)r, (void)n, (void)a, (void)b; return fmi3Error; }
EXPORT S fmi3SetIntervalDecimal(C c, const Ref r[], size_t n, const fmi3Float64 v[]) { (void)c, (void)r, (void)n, (void)v; return fmi3Error; }
EXPORT S fmi3SetIntervalFraction(C c, const Ref r[], size_t n, const fmi3UInt64 a[], const fmi3UInt64 b[]) { (void)c, (void)r, (void)n, (void)a, (void)b; return fmi3Error; }
EXPORT S fmi3SetShiftDecimal(C c, const Ref r[], size_t n, const fmi3Float64 v[]) { (void)c, (void)r, (void)n, (void)v; return fmi3Error; }
EXPORT S fmi3SetShiftFraction(C c, const Ref r[], size_t n, const fmi3UInt64 a[], const fmi3UInt64 b[]) { (void)c, (void)r, (void)n, (void)a, (void)b; return fmi3Error; }
EXPORT S fmi3EvaluateDiscreteStates(C c) { return ok(c); }
EXPORT S fmi3UpdateDiscreteStates(C c, fmi3Boolean *again, fmi3Boolean *stop, fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    *again = *stop = *nominals = *values = *defined = fmi3False, *next = 0;
    return touches(c), fmi3OK;
}

EXPORT S fmi3EnterContinuousTimeMode(C c) { return ok(c); }
EXPORT S fmi3CompletedIntegratorStep(C c, fmi3Boolean n, fmi3Boolean *enter, fmi3Boolean *stop) { (void)n; *enter = *stop = fmi3False; return ok(c); }
EXPORT S fmi3SetTime(C c, fmi3Float64 t) { return ((Instance *)c)->value[TIME] = t, fmi3OK; }
EXPORT S fmi3SetContinuousStates(C c, const fmi3Float64 x[], size_t n) {
    EACH(n) set(c, X + (unsigned)i, x[i]);
    return n == STATES ? fmi3OK : fmi3Error;
}
EXPORT S fmi3GetContinuousStateDerivatives(C c, fmi3Float64 d[], size_t n) { EACH(n) d[i] = get(c, DER_X + (unsigned)i); return fmi3OK; }
EXPORT S fmi3GetEventIndicators(C c, fmi3Float64 e[], size_t n) { EACH(n) e[i] = get(c, INDICATORS + (unsigned)i); return fmi3OK; }
EXPORT S fmi3GetContinuousStates(C c, fmi3Float64 x[], size_t n) { EACH(n) x[i] = get(c, X + (unsigned)i); return fmi3OK; }
EXPORT S fmi3GetNominalsOfContinuousStates(C c, fmi3Float64 x[], size_t n) { EACH(n) x[i] = 1; return ok(c); }
EXPORT S fmi3GetNumberOfEventIndicators(C c, size_t *n) { *n = 2; return ok(c); }
EXPORT S fmi3GetNumberOfContinuousStates(C c, size_t *n) { *n = STATES; return ok(c); }

EXPORT S fmi3EnterStepMode(C c) { return ok(c); }
EXPORT S fmi3GetOutputDerivatives(C c, const Ref r[], size_t n, const fmi3Int32 o[], fmi3Float64 v[], size_t nv) { (void)c, (void)r, (void)o, (void)v, (void)nv; return n ? fmi3Error : fmi3OK; }
EXPORT S fmi3DoStep(C c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean n, fmi3Boolean *event, fmi3Boolean *stop, fmi3Boolean *early, fmi3Float64 *last) {
    (void)n;
    *event = *stop = *early = fmi3False, *last = t + h;
    ((Instance *)c)->value[TIME] = t;
    return sail(c, h) ? fmi3OK : fmi3Error;
}
EXPORT S fmi3ActivateModelPartition(C c, Ref r, fmi3Float64 t) { (void)c, (void)r, (void)t; return fmi3Error; }
