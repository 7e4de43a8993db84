/* The interface of FMI 2.0, model exchange and co-simulation, to a ship (instance.h). */
#include "instance.h"
#include "fmi2Functions.h"

#define EXPORT FMI2_Export
#define EACH(n) for (size_t i = 0; i < (n); ++i)
#define MAY(modes) do { if (!may(c, modes)) return fmi2Error; } while (0)
typedef fmi2Status S;
typedef fmi2Component C;
typedef fmi2ValueReference Ref;
typedef struct {
    Instance ship;
    const fmi2CallbackFunctions *calls;
    char name[64];
} Component;

static void tell(void *whom, const char *sentence) {
    const Component *c = whom;
    if (c->calls && c->calls->logger)
        c->calls->logger(c->calls->componentEnvironment, c->name, fmi2Error, "logStatusError", "%s", sentence);
}
static Numbers *numbers(C c) { return &((Instance *)c)->now; }
static S status(int right) { return right ? fmi2OK : fmi2Error; }
static S none(C c, size_t n) { return n ? status(refuse(c, "there is no variable of this type, or it cannot be set")) : fmi2OK; }
static S moved(C c, int from, int to) { return may(c, from) ? (numbers(c)->mode = to, fmi2OK) : fmi2Error; }

EXPORT const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
EXPORT const char *fmi2GetVersion(void) { return fmi2Version; }
EXPORT S fmi2SetDebugLogging(C c, fmi2Boolean on, size_t n, const fmi2String which[]) {
    (void)c, (void)on, (void)n, (void)which;
    return fmi2OK;
}
EXPORT C fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                         const fmi2CallbackFunctions *calls, fmi2Boolean visible, fmi2Boolean logging) {
    (void)place, (void)visible, (void)logging;
    if (!guid || strcmp(guid, TOKEN) || (type != fmi2ModelExchange && type != fmi2CoSimulation)) return NULL;
    Component *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    if (name) strncpy(c->name, name, sizeof c->name - 1);
    c->calls = calls, c->ship.tell = tell, c->ship.whom = c, c->ship.exchange = type == fmi2ModelExchange;
    reset(&c->ship);
    return c;
}
EXPORT void fmi2FreeInstance(C c) { free(c); }
EXPORT S fmi2SetupExperiment(C c, fmi2Boolean t, fmi2Real tol, fmi2Real start, fmi2Boolean s, fmi2Real stop) {
    (void)t, (void)tol;
    MAY(MADE);
    if (!isfinite(start) || (s && !(stop > start))) return status(refuse(c, "the experiment has no time: start and stop must rise"));
    numbers(c)->value[TIME] = start, numbers(c)->stop = s ? stop : INFINITY;
    return fmi2OK;
}
EXPORT S fmi2EnterInitializationMode(C c) { return moved(c, MADE, STARTING); }
EXPORT S fmi2ExitInitializationMode(C c) {
    MAY(STARTING);
    return starts(c) ? moved(c, STARTING, ((Instance *)c)->exchange ? EVENT : STEPPING) : fmi2Error;
}
EXPORT S fmi2Terminate(C c) { return moved(c, RUNNING, ENDED); }
EXPORT S fmi2Reset(C c) { return reset(c), fmi2OK; }

EXPORT S fmi2GetReal(C c, const Ref r[], size_t n, fmi2Real v[]) {
    EACH(n) {
        if (!may_get(c, r[i], REALS)) return fmi2Error;
        v[i] = get(c, r[i]);
    }
    return fmi2OK;
}
EXPORT S fmi2SetReal(C c, const Ref r[], size_t n, const fmi2Real v[]) {
    EACH(n) if (!assign(c, r[i], v[i])) return fmi2Error;
    return fmi2OK;
}
EXPORT S fmi2GetBoolean(C c, const Ref r[], size_t n, fmi2Boolean v[]) {
    EACH(n) {
        if (!may_get(c, r[i], TRUTHS)) return fmi2Error;
        v[i] = get(c, r[i]) != 0.0;
    }
    return fmi2OK;
}
EXPORT S fmi2GetInteger(C c, const Ref r[], size_t n, fmi2Integer v[]) {
    EACH(n) {
        if (!may_get(c, r[i], INTEGERS)) return fmi2Error;
        v[i] = (fmi2Integer)get(c, r[i]);
    }
    return fmi2OK;
}
EXPORT S fmi2GetString(C c, const Ref r[], size_t n, fmi2String v[]) { return (void)r, (void)v, none(c, n); }
EXPORT S fmi2SetInteger(C c, const Ref r[], size_t n, const fmi2Integer v[]) { return (void)r, (void)v, none(c, n); }
EXPORT S fmi2SetBoolean(C c, const Ref r[], size_t n, const fmi2Boolean v[]) { return (void)r, (void)v, none(c, n); }
EXPORT S fmi2SetString(C c, const Ref r[], size_t n, const fmi2String v[]) { return (void)r, (void)v, none(c, n); }

/* All of a ship is numbers, so its state is a copy of them. */
EXPORT S fmi2GetFMUstate(C c, fmi2FMUstate *s) {
    if (!*s) *s = malloc(sizeof(Numbers));
    if (!*s) return fmi2Error;
    memcpy(*s, numbers(c), sizeof(Numbers));
    return fmi2OK;
}
EXPORT S fmi2SetFMUstate(C c, fmi2FMUstate s) { return s ? (memcpy(numbers(c), s, sizeof(Numbers)), fmi2OK) : fmi2Error; }
EXPORT S fmi2FreeFMUstate(C c, fmi2FMUstate *s) { return (void)c, free(*s), *s = NULL, fmi2OK; }
EXPORT S fmi2SerializedFMUstateSize(C c, fmi2FMUstate s, size_t *n) { return (void)c, (void)s, *n = sizeof(Numbers), fmi2OK; }
EXPORT S fmi2SerializeFMUstate(C c, fmi2FMUstate s, fmi2Byte to[], size_t n) {
    (void)c;
    if (!s || n < sizeof(Numbers)) return fmi2Error;
    memcpy(to, s, sizeof(Numbers));
    return fmi2OK;
}
EXPORT S fmi2DeSerializeFMUstate(C c, const fmi2Byte from[], size_t n, fmi2FMUstate *s) {
    if (n != sizeof(Numbers) || fmi2GetFMUstate(c, s) != fmi2OK) return fmi2Error;
    memcpy(*s, from, sizeof(Numbers));
    return fmi2OK;
}
EXPORT S fmi2GetDirectionalDerivative(C c, const Ref u[], size_t nu, const Ref k[], size_t nk, const fmi2Real dk[], fmi2Real du[]) {
    return (void)u, (void)nu, (void)k, (void)nk, (void)dk, (void)du, status(refuse(c, "this FMU gives no derivatives"));
}

EXPORT S fmi2EnterEventMode(C c) { return moved(c, EVENT | CONTINUOUS, EVENT); }
EXPORT S fmi2NewDiscreteStates(C c, fmi2EventInfo *e) {
    MAY(EVENT);
    memset(e, 0, sizeof *e);
    e->valuesOfContinuousStatesChanged = update(c);
    return fmi2OK;
}
EXPORT S fmi2EnterContinuousTimeMode(C c) { return moved(c, EVENT, CONTINUOUS); }
EXPORT S fmi2CompletedIntegratorStep(C c, fmi2Boolean n, fmi2Boolean *enter, fmi2Boolean *stop) {
    (void)n;
    MAY(CONTINUOUS);
    *enter = is_beyond_changed(c), *stop = fmi2False;
    return fmi2OK;
}
EXPORT S fmi2SetTime(C c, fmi2Real t) {
    MAY(EVENT | CONTINUOUS);
    if (!isfinite(t)) return status(refuse(c, "the time is no number"));
    return numbers(c)->value[TIME] = t, fmi2OK;
}
EXPORT S fmi2SetContinuousStates(C c, const fmi2Real x[], size_t n) {
    MAY(CONTINUOUS);
    if (n != STATES) return fmi2Error;
    EACH(n) if (!isfinite(x[i])) return status(refuse(c, "a state is no number"));
    EACH(n) put(numbers(c), X + (unsigned)i, x[i]);
    return fmi2OK;
}
EXPORT S fmi2GetDerivatives(C c, fmi2Real d[], size_t n) {
    MAY(STARTING | EVENT | CONTINUOUS | ENDED);
    if (n != STATES) return fmi2Error;
    EACH(n) d[i] = get(c, DER + (unsigned)i);
    return fmi2OK;
}
EXPORT S fmi2GetEventIndicators(C c, fmi2Real e[], size_t n) {
    MAY(STARTING | EVENT | CONTINUOUS | ENDED);
    if (n != EVENTS) return fmi2Error;
    EACH(n) e[i] = get(c, INDICATORS + (unsigned)i);
    return fmi2OK;
}
EXPORT S fmi2GetContinuousStates(C c, fmi2Real x[], size_t n) {
    MAY(STARTING | EVENT | CONTINUOUS | ENDED);
    if (n != STATES) return fmi2Error;
    EACH(n) x[i] = get(c, X + (unsigned)i);
    return fmi2OK;
}
EXPORT S fmi2GetNominalsOfContinuousStates(C c, fmi2Real x[], size_t n) {
    EACH(n) x[i] = 1.0;
    return (void)c, fmi2OK;
}

EXPORT S fmi2DoStep(C c, fmi2Real t, fmi2Real h, fmi2Boolean n) {
    double reached;
    (void)n;
    MAY(STEPPING);
    return status(integrate(c, t, h, &reached));
}
EXPORT S fmi2CancelStep(C c) { return status(refuse(c, "no step is under way")); }
EXPORT S fmi2SetRealInputDerivatives(C c, const Ref r[], size_t n, const fmi2Integer o[], const fmi2Real v[]) {
    return (void)r, (void)o, (void)v, none(c, n);
}
EXPORT S fmi2GetRealOutputDerivatives(C c, const Ref r[], size_t n, const fmi2Integer o[], fmi2Real v[]) {
    return (void)r, (void)o, (void)v, none(c, n);
}
EXPORT S fmi2GetStatus(C c, const fmi2StatusKind s, fmi2Status *v) { return (void)c, (void)s, (void)v, fmi2Discard; }
EXPORT S fmi2GetRealStatus(C c, const fmi2StatusKind s, fmi2Real *v) {
    if (s != fmi2LastSuccessfulTime) return fmi2Discard;
    *v = numbers(c)->value[TIME];
    return fmi2OK;
}
EXPORT S fmi2GetIntegerStatus(C c, const fmi2StatusKind s, fmi2Integer *v) { return (void)c, (void)s, (void)v, fmi2Discard; }
EXPORT S fmi2GetBooleanStatus(C c, const fmi2StatusKind s, fmi2Boolean *v) { return (void)c, (void)s, *v = fmi2False, fmi2OK; }
EXPORT S fmi2GetStringStatus(C c, const fmi2StatusKind s, fmi2String *v) { return (void)c, (void)s, (void)v, fmi2Discard; }
