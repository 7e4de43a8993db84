/* In place of Simulink: one block, its rates and its outputs, and the solver ode4 until the block stops. */
static SimStruct block;

const char *begin(const double *start, int count, const double *input) {
    block = (SimStruct){.parameter = {start, count}};
    mdlInitializeSizes(&block);
    if (block.error) return block.error;
    mdlInitializeSampleTimes(&block);
    mdlInitializeConditions(&block);
    for (int i = 0; i < block.inputs; ++i) block.input[i] = input[i];
    return NULL;
}
void rates(double *dx, double *outputs) {
    mdlOutputs(&block, 0);
    mdlDerivatives(&block);
    for (int i = 0; i < block.states; ++i) *dx++ = block.dx[i];
    for (int port = 0; port < 3; ++port)
        for (int i = 0; i < block.widths[port]; ++i) *outputs++ = block.output[port][i];
    mdlZeroCrossings(&block);
    for (int i = 0; i < block.zero_crossings; ++i) *outputs++ = block.crossing[i];
}
int integrate(double length, int steps, double *end) {
    const double share[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    int step = 0;
    for (; step < steps; ++step) {
        double before[32], after[32];
        mdlOutputs(&block, 0);
        if (block.stopped) break;
        for (int i = 0; i < block.states; ++i) before[i] = after[i] = block.x[i];
        for (int stage = 0; stage < 4; ++stage) {
            for (int i = 0; i < block.states; ++i) block.x[i] = before[i] + (stage ? share[stage] * length * block.dx[i] : 0.0);
            mdlDerivatives(&block);
            for (int i = 0; i < block.states; ++i) after[i] += weight[stage] * length * block.dx[i];
        }
        for (int i = 0; i < block.states; ++i) block.x[i] = after[i];
    }
    for (int i = 0; i < block.states; ++i) end[i] = block.x[i];
    mdlTerminate(&block);
    return step;
}
