/* Loads the library of an FMU for Windows, sails it in equal steps, and prints the numbers that it was told after each. */
#include <stdio.h>
#include <stdlib.h>
#include <windows.h>
#include "fmi2Functions.h"

#define FUNCTION(name) name##TYPE *name = (name##TYPE *)(void *)GetProcAddress(library, #name)

/* Arguments: the library, the token, steps, their length [s], then reference and value of each number. */
int main(int count, char **told) {
    HMODULE library = LoadLibraryA(told[1]);
    if (!library) return 2;
    FUNCTION(fmi2Instantiate);
    FUNCTION(fmi2SetupExperiment);
    FUNCTION(fmi2EnterInitializationMode);
    FUNCTION(fmi2ExitInitializationMode);
    FUNCTION(fmi2SetReal);
    FUNCTION(fmi2GetReal);
    FUNCTION(fmi2DoStep);
    const fmi2CallbackFunctions callbacks = {0};
    fmi2Component ship = fmi2Instantiate("ship", fmi2CoSimulation, told[2], "", &callbacks, 0, 0);
    const int steps = atoi(told[3]), numbers = (count - 5) / 2;
    const double length = atof(told[4]);
    fmi2ValueReference places[16];
    double values[16];
    for (int number = 0; number < numbers; ++number)
        places[number] = (unsigned)atoi(told[5 + 2 * number]), values[number] = atof(told[6 + 2 * number]);
    if (!ship || fmi2SetupExperiment(ship, 0, 0.0, 0.0, 0, 0.0)) return 3;
    if (fmi2EnterInitializationMode(ship) || fmi2SetReal(ship, places, (size_t)numbers, values)) return 4;
    if (fmi2ExitInitializationMode(ship)) return 5;
    for (int step = 0; step < steps; ++step) {
        if (fmi2DoStep(ship, step * length, length, 1) || fmi2GetReal(ship, places, (size_t)numbers, values)) return 6;
        for (int number = 0; number < numbers; ++number) printf("%.17g ", values[number]);
        puts("");
    }
    return 0;
}
