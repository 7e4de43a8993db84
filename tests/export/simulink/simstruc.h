/* The part of Simulink's simstruc.h that an exported S-function uses, with one block behind it. */
#include <stddef.h>

typedef double real_T;
typedef int int_T;
typedef struct { const double *numbers; int count; } mxArray;
typedef struct {
    mxArray parameter;
    const char *error;
    int parameters, states, inputs, widths[3], zero_crossings, stopped;
    double x[32], dx[32], input[16], output[3][32], crossing[8];
} SimStruct;

#define SS_OPTION_EXCEPTION_FREE_CODE 1
#define CONTINUOUS_SAMPLE_TIME 0.0
#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) 1
#define ssGetSFcnParam(S, i) (&(S)->parameter + (i))
#define mxGetNumberOfElements(array) ((size_t)(array)->count)
#define mxGetPr(array) ((array)->numbers)
#define ssSetErrorStatus(S, text) ((S)->error = (text))
#define ssSetNumContStates(S, n) ((S)->states = (n))
#define ssSetNumDiscStates(S, n) ((void)(S), (void)(n))
#define ssSetNumInputPorts(S, n) ((void)(S), (n) == 1)
#define ssSetInputPortWidth(S, port, n) ((S)->inputs = (n))
#define ssSetInputPortRequiredContiguous(S, port, is) ((void)(S))
#define ssSetInputPortDirectFeedThrough(S, port, is) ((void)(S))
#define ssSetNumOutputPorts(S, n) ((void)(S), (n) == 3)
#define ssSetOutputPortWidth(S, port, n) ((S)->widths[port] = (n))
#define ssSetNumSampleTimes(S, n) ((void)(S))
#define ssSetNumNonsampledZCs(S, n) ((S)->zero_crossings = (n))
#define ssSetOptions(S, options) ((void)(S))
#define ssSetSampleTime(S, i, time) ((void)(S))
#define ssSetOffsetTime(S, i, time) ((void)(S))
#define ssGetContStates(S) ((S)->x)
#define ssGetdX(S) ((S)->dx)
#define ssGetInputPortRealSignal(S, port) ((const real_T *)(S)->input)
#define ssGetOutputPortRealSignal(S, port) ((S)->output[port])
#define ssGetNonsampledZCs(S) ((S)->crossing)
#define ssIsMajorTimeStep(S) 1
#define ssSetStopRequested(S, is) ((S)->stopped = (is))
