"""A simulated bridge: a voyage told second by second as its sensors indicate it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from narrows.readers.nmea.nmea_lines import checksum
from narrows.simulation.voyage import Voyage
from narrows.warning.monitoring.bridge_sentences import bridge_sentences
from narrows.waterway.waterway import Waterway

# Standard deviations of what sensors indicate.
NOISE = {
    "x": 1.0, "y": 1.0, "psi": math.radians(0.2), "r": math.radians(0.03), "u": 0.05, "course": 0.01, "speed": 0.05,
    "rudder": math.radians(0.2),
}  # fmt: skip


@dataclass(frozen=True)
class SimulatedBridge:
    """A voyage and what is told of it."""

    voyage: Voyage  # Of steps of a second, along a waterway
    waterway: Waterway  # Along which, that knows where on earth it is
    began: float  # Since 1970 [s]
    seed: int = 0  # Of the sensors' noise

    def seconds(self) -> Iterator[tuple[float, list[str]]]:
        """Yield each second since 1970, and the sentences of it."""
        random, voyage = np.random.default_rng(self.seed), self.voyage
        for row, t in enumerate(voyage.t):
            now = {name: float(voyage[name][row]) for name in ("x", "y", "psi", "r", "u", "rudder")}
            v = float(voyage.v[row])
            now |= {"course": now["psi"] + math.atan2(v, now["u"]), "speed": math.hypot(now["u"], v)}
            told = {name: value + NOISE[name] * random.standard_normal() for name, value in now.items()}
            yield self.began + float(t), bridge_sentences(self.waterway, told, self.began + float(t))

    def recording(self) -> bytes:
        """Return what a logger would have written, its times before the sentences."""
        lines = [f"{_stamp(t)}{line}" for t, told in self.seconds() for line in told]
        return "".join(lines).encode("ascii")


def _stamp(since_1970: float) -> str:
    """The block before a sentence with the logger's time (IEC 61162-450)."""
    body = f"c:{since_1970:.0f}"
    return f"\\{body}*{checksum(body.encode()):02X}\\"
