"""The columns that an ensemble keeps: what stands where no voyage was run, units, the meaning of codes."""

from typing import Any

import numpy as np

from narrows.simulation.outcome import BEGINNING, END, KINDS, Code

NOT_RUN = -1
UNITS = {"time": "s", "distance": "m", "y_end": "m", "psi_end": "rad", "u_end": "m/s", "v_end": "m/s", "r_end": "rad/s"}


def empty_of(kind: type) -> Any:
    """What stands where no voyage was run."""
    return NOT_RUN if issubclass(kind, np.integer) else np.nan


def attributes_of(name: str) -> dict[str, Any]:
    """Units, and the meaning of codes in the way of the CF conventions."""
    if name == "outcome":
        codes = {NOT_RUN: "not run", **{int(code): kind for code, kind in KINDS.items()}}
        for code, way in ((Code.ASTERN, BEGINNING), (Code.PASSED, END)):
            codes[int(code)] = f"{KINDS[code]} by its {way}"
        meanings = " ".join(word.replace(" ", "_") for word in codes.values())
        return {"flag_values": list(codes), "flag_meanings": meanings}
    if name == "side":
        return {"flag_values": [-1, 0, 1], "flag_meanings": "port none starboard"}
    long_name = {"time": "time of the end", "distance": "distance along the canal"}.get(
        name, f"{name.removesuffix('_end')} at the end"
    )
    return {"units": UNITS[name], "long_name": long_name}
