"""Exported headers compiled by the machine's own compiler and called through ctypes."""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import narrows as nw

COMPILER = shutil.which("gcc") or shutil.which("cc")
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler is here to try the exported header with")
CALLS = """
#include "ship.h"
#ifdef WATER
#define CANAL , &ship_canal
#define OF_BANKS &ship_canal
#else
#define CANAL
#define OF_BANKS &k
#endif
static ship_constants k;
static ship_inputs in;
static const double *of_inputs = (const double *)(const void *)&in;
void prepare(const double *p, const double *i) {
    ship_prepare((const ship_parameters *)(const void *)p, &k);
    in = *(const ship_inputs *)(const void *)i;
}
void defaults(double *p, double *i) {
    *(ship_parameters *)(void *)p = ship_model;
    *(ship_inputs *)(void *)i = ship_at_rest;
}
int parameters(void) { return (int)(sizeof(ship_parameters) / sizeof(double)); }
int inputs(void) { return (int)(sizeof(ship_inputs) / sizeof(double)); }
int states(void) { return SHIP_STATES; }
void rates(const double *z, double *out) { ship_rates(z, &in, &k CANAL, out); }
void by_state(const double *z, double *out) { ship_by_state(z, &in, &k CANAL, out); }
void by_input(const double *z, double *out) { ship_by_input(z, &in, &k CANAL, out); }
void by_coefficient(const double *z, double *out) { ship_by_coefficient(z, &in, &k CANAL, out); }
void step(const double *z, double h, double *out) { ship_step(z, out, h, &in, &k CANAL); }
void block(const double *z, double h, double *out) {
    static double state[SHIP_NUMBERS][SHIP_LANES], given[sizeof(ship_inputs) / sizeof(double)][SHIP_LANES];
    for (int lane = 0; lane < SHIP_LANES; ++lane) {
        for (int j = 0; j < SHIP_STATES; ++j) state[j][lane] = z[SHIP_STATES * lane + j];
        for (int j = 0; j < inputs(); ++j) given[j][lane] = lane % 2 ? 0.5 * of_inputs[j] : of_inputs[j];
    }
    ship_step_block(state, h, given, &k CANAL);
    for (int lane = 0; lane < SHIP_LANES; ++lane)
        for (int j = 0; j < SHIP_NUMBERS; ++j) out[SHIP_NUMBERS * lane + j] = state[j][lane];
}
void clearance(const double *z, double *out) { ship_clearance(z, out, OF_BANKS); }
int beyond(const double *z) { return ship_beyond(z, &k CANAL); }
int integrate(double *z, double h, double time, double *end) { return ship_integrate(z, &in, &k CANAL, h, time, end); }
"""


class CompiledShip:
    """A header as a library of this process."""

    def __init__(self, model: nw.Model, folder: Path, **choices: Any) -> None:
        nw.export.write(model, folder / "ship.h", **choices)
        (folder / "calls.c").write_text(CALLS, encoding="utf-8")
        water = ["-DWATER"] if choices.get("waterway") else []
        subprocess.run(
            [
                COMPILER,
                *FLAGS,
                *water,
                "-shared",
                "-fPIC",
                str(folder / "calls.c"),
                "-o",
                str(folder / "ship.so"),
                "-lm",
            ],
            check=True,
        )
        self.library = ctypes.CDLL(str(folder / "ship.so"))
        self.parameters = np.zeros(self.library.parameters())
        self.inputs = np.zeros(self.library.inputs())
        self.library.defaults(pointer(self.parameters), pointer(self.inputs))
        text = (folder / "ship.h").read_text(encoding="utf-8")
        self.names = fields(text, "inputs")
        self.at_rest = self.inputs.copy()
        self.set()

    def set(self, **inputs: float) -> None:
        """Give inputs by name; the others are at rest."""
        self.inputs[:] = self.at_rest
        for name, value in inputs.items():
            self.inputs[self.names.index(name)] = value
        self.library.prepare(pointer(self.parameters), pointer(self.inputs))

    def called(self, name: str, state: Sequence[float], size: int, *more: float) -> np.ndarray:
        """What a function of the header writes."""
        out, at = np.zeros(size), np.array(state, float)
        getattr(self.library, name)(pointer(at), *map(ctypes.c_double, more), pointer(out))
        return out

    def integrate(self, state: Sequence[float], dt: float, duration: float) -> tuple[int, float, float, np.ndarray]:
        """How a voyage ends: outcome, time, lean and state."""
        at, end = np.array([*state, 0.0, 0.0], float), np.zeros(2)
        outcome = self.library.integrate(pointer(at), ctypes.c_double(dt), ctypes.c_double(duration), pointer(end))
        return outcome, end[0], end[1], at[:-2]


def pointer(array: np.ndarray) -> Any:
    """Of an array of doubles."""
    return array.ctypes.data_as(ctypes.c_void_p)


def fields(text: str, structure: str) -> list[str]:
    """The fields of a structure, in order."""
    body = text[: text.index(f"}} ship_{structure};")].rpartition("typedef struct {")[2]
    return [line.split(";")[0].removeprefix("double ") for line in map(str.strip, body.splitlines()) if line]
