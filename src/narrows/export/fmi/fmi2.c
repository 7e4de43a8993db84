/* The interface of FMI 2.0, model exchange and co-simulation, to a ship (instance.h). */
#include "fmi2Functions.h"
#include "instance.h"

#define EXPORT FMI2_Export
#define EACH(n) for (size_t i = 0; i < (n); ++i)
typedef fmi2Status S;
typedef fmi2Component C;
typedef struct {
    Instance ship;
    const fmi2CallbackFunctions *calls;
    char name[64];
} Component;

static void tell(void *whom, const char *sentence, double number) {
    const Component *c = whom;
    if (c->calls && c->calls->logger)
        c->calls->logger(c->calls->componentEnvironment, c->name, fmi2Error, "logStatusError", sentence, number);
}
static S none(size_t n) { return n ? fmi2Error : fmi2OK; }

EXPORT const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
EXPORT const char *fmi2GetVersion(void) { return fmi2Version; }
EXPORT S fmi2SetDebugLogging(C c, fmi2Boolean on, size_t n, const fmi2String which[]) {
    (void)c, (void)on, (void)n, (void)which;
    return fmi2OK;
}
EXPORT C fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                         const fmi2CallbackFunctions *calls, fmi2Boolean visible, fmi2Boolean logging) {
    (void)place, (void)visible, (void)logging;
    if (!guid || strcmp(guid, TOKEN)) return NULL;
    Component *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    if (name) strncpy(c->name, name, sizeof c->name - 1);
    c->calls = calls, c->ship.tell = tell, c->ship.whom = c, c->ship.exchange = type == fmi2ModelExchange;
    reset(&c->ship);
    return c;
}
EXPORT void fmi2FreeInstance(C c) { free(c); }
EXPORT S fmi2SetupExperiment(C c, fmi2Boolean t, fmi2Real tol, fmi2Real start, fmi2Boolean s, fmi2Real stop) {
    (void)t, (void)tol, (void)s, (void)stop;
    ((Instance *)c)->value[TIME] = start;
    return fmi2OK;
}
EXPORT S fmi2EnterInitializationMode(C c) { return (void)c, fmi2OK; }
EXPORT S fmi2ExitInitializationMode(C c) { return starts_afloat(c) ? fmi2OK : fmi2Error; }
EXPORT S fmi2Terminate(C c) { return (void)c, fmi2OK; }
EXPORT S fmi2Reset(C c) { return reset(c), fmi2OK; }

EXPORT S fmi2GetReal(C c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    EACH(n) {
        if (r[i] >= COUNT) return fmi2Error;
        v[i] = get(c, r[i]);
    }
    return fmi2OK;
}
EXPORT S fmi2SetReal(C c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    EACH(n) {
        if (r[i] >= COUNT) return fmi2Error;
        set(c, r[i], v[i]);
    }
    return fmi2OK;
}
EXPORT S fmi2GetBoolean(C c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[]) {
    EACH(n) {
        if (r[i] != AGROUND) return fmi2Error;
        v[i] = get(c, r[i]) != 0.0;
    }
    return fmi2OK;
}
EXPORT S fmi2GetInteger(C c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) { return (void)c, (void)r, (void)v, none(n); }
EXPORT S fmi2GetString(C c, const fmi2ValueReference r[], size_t n, fmi2String v[]) { return (void)c, (void)r, (void)v, none(n); }
EXPORT S fmi2SetInteger(C c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]) { return (void)c, (void)r, (void)v, none(n); }
EXPORT S fmi2SetBoolean(C c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[]) { return (void)c, (void)r, (void)v, none(n); }
EXPORT S fmi2SetString(C c, const fmi2ValueReference r[], size_t n, const fmi2String v[]) { return (void)c, (void)r, (void)v, none(n); }

/* All of a ship is numbers, so its state is a copy of them. */
EXPORT S fmi2GetFMUstate(C c, fmi2FMUstate *s) {
    if (!*s) *s = malloc(sizeof(Instance));
    if (!*s) return fmi2Error;
    memcpy(*s, c, sizeof(Instance));
    return fmi2OK;
}
EXPORT S fmi2SetFMUstate(C c, fmi2FMUstate s) { return restore(c, s), fmi2OK; }
EXPORT S fmi2FreeFMUstate(C c, fmi2FMUstate *s) { return (void)c, free(*s), *s = NULL, fmi2OK; }
EXPORT S fmi2SerializedFMUstateSize(C c, fmi2FMUstate s, size_t *n) { return (void)c, (void)s, *n = sizeof(Instance), fmi2OK; }
EXPORT S fmi2SerializeFMUstate(C c, fmi2FMUstate s, fmi2Byte to[], size_t n) {
    (void)c;
    if (n < sizeof(Instance)) return fmi2Error;
    memcpy(to, s, sizeof(Instance));
    return fmi2OK;
}
EXPORT S fmi2DeSerializeFMUstate(C c, const fmi2Byte from[], size_t n, fmi2FMUstate *s) {
    if (n < sizeof(Instance) || fmi2GetFMUstate(c, s) != fmi2OK) return fmi2Error;
    memcpy(*s, from, sizeof(Instance));
    return fmi2OK;
}
EXPORT S fmi2GetDirectionalDerivative(C c, const fmi2ValueReference u[], size_t nu, const fmi2ValueReference k[],
                                      size_t nk, const fmi2Real dk[], fmi2Real du[]) {
    EACH(nu) {
        du[i] = 0.0;
        for (size_t j = 0; j < nk; ++j) du[i] += slope(c, u[i], k[j]) * dk[j];
    }
    return fmi2OK;
}

EXPORT S fmi2EnterEventMode(C c) { return (void)c, fmi2OK; }
EXPORT S fmi2NewDiscreteStates(C c, fmi2EventInfo *e) { return memset(e, 0, sizeof *e), touches(c), fmi2OK; }
EXPORT S fmi2EnterContinuousTimeMode(C c) { return (void)c, fmi2OK; }
EXPORT S fmi2CompletedIntegratorStep(C c, fmi2Boolean n, fmi2Boolean *enter, fmi2Boolean *stop) {
    return (void)c, (void)n, *enter = *stop = fmi2False, fmi2OK;
}
EXPORT S fmi2SetTime(C c, fmi2Real t) { return ((Instance *)c)->value[TIME] = t, fmi2OK; }
EXPORT S fmi2SetContinuousStates(C c, const fmi2Real x[], size_t n) {
    EACH(n) set(c, X + (unsigned)i, x[i]);
    return n == STATES ? fmi2OK : fmi2Error;
}
EXPORT S fmi2GetDerivatives(C c, fmi2Real d[], size_t n) {
    EACH(n) d[i] = get(c, DER_X + (unsigned)i);
    return fmi2OK;
}
EXPORT S fmi2GetEventIndicators(C c, fmi2Real e[], size_t n) {
    EACH(n) e[i] = get(c, AGROUND) != 0.0 ? -1.0 : room(c);
    return fmi2OK;
}
EXPORT S fmi2GetContinuousStates(C c, fmi2Real x[], size_t n) {
    EACH(n) x[i] = get(c, X + (unsigned)i);
    return fmi2OK;
}
EXPORT S fmi2GetNominalsOfContinuousStates(C c, fmi2Real x[], size_t n) {
    EACH(n) x[i] = 1.0;
    return (void)c, fmi2OK;
}

EXPORT S fmi2DoStep(C c, fmi2Real t, fmi2Real h, fmi2Boolean n) {
    (void)n;
    ((Instance *)c)->value[TIME] = t;
    return sail(c, h) ? fmi2OK : fmi2Error;
}
EXPORT S fmi2CancelStep(C c) { return (void)c, fmi2Error; }
EXPORT S fmi2SetRealInputDerivatives(C c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], const fmi2Real v[]) {
    return (void)c, (void)r, (void)o, (void)v, none(n);
}
EXPORT S fmi2GetRealOutputDerivatives(C c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], fmi2Real v[]) {
    return (void)c, (void)r, (void)o, (void)v, none(n);
}
EXPORT S fmi2GetStatus(C c, const fmi2StatusKind s, fmi2Status *v) { return (void)c, (void)s, (void)v, fmi2Discard; }
EXPORT S fmi2GetRealStatus(C c, const fmi2StatusKind s, fmi2Real *v) {
    if (s != fmi2LastSuccessfulTime) return fmi2Discard;
    *v = ((Instance *)c)->value[TIME];
    return fmi2OK;
}
EXPORT S fmi2GetIntegerStatus(C c, const fmi2StatusKind s, fmi2Integer *v) { return (void)c, (void)s, (void)v, fmi2Discard; }
EXPORT S fmi2GetBooleanStatus(C c, const fmi2StatusKind s, fmi2Boolean *v) { return (void)c, (void)s, *v = fmi2False, fmi2OK; }
EXPORT S fmi2GetStringStatus(C c, const fmi2StatusKind s, fmi2String *v) { return (void)c, (void)s, (void)v, fmi2Discard; }
