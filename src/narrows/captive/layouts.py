"""Layouts of laboratories' tables, which are converted; any other table must have the documented columns."""

import re
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pandas as pd

from narrows.base.errors import InputError
from narrows.captive.settings import SHORTEST_RECORD
from narrows.readers.cells import numbers
from narrows.ship.particulars import wall_of

Translated = tuple[pd.DataFrame, tuple[str, ...]]


class Layout:
    """A layout of tables; the first line of a docstring names the laboratory."""

    HEADERS: ClassVar[Sequence[str]]  # Headers that no other layout has together

    @classmethod
    def recognises(cls, frame: pd.DataFrame) -> bool:
        return set(cls.HEADERS) <= set(frame.columns)

    @classmethod
    def translated(cls, frame: pd.DataFrame, chosen: str, table: str) -> Translated:
        """Convert a frame of the layout to the documented headers, with notes; ``chosen`` is the user's selection."""
        raise NotImplementedError


class Dtc(Layout):
    """Raw records of the DTC tests for MASHCON 2019: tab separated, two header lines, positions without rates.

    The speed column of these files is a stepped encoder value, so velocities and accelerations come from the low-passed
    positions; forces are unfiltered.
    """

    # Cutoff frequency of the low-pass [Hz]: ramps last seconds, the tank's carriage vibrates above one hertz.
    CUTOFF = 0.5
    HEADERS = ("time [s]", "x0 [m]", "y0 [m]", "psi [°]", "heave [mm]", "X [N]", "Y [N]", "N [Nm]")

    @classmethod
    def translated(cls, frame: pd.DataFrame, chosen: str, table: str) -> Translated:
        t, x, y, degrees = (numbers(frame, header, table) for header in cls.HEADERS[:4])
        psi = np.unwrap(np.radians(degrees))
        try:
            (north, ahead), (east, aside), (r, rdot) = (rates(t, position, cls.CUTOFF) for position in (x, y, psi))
        except InputError as error:
            raise InputError(f"{table}: {error}") from None
        c, s = np.cos(psi), np.sin(psi)
        u, v = north * c + east * s, east * c - north * s
        translation = {
            "t": t, "x": x, "y": y, "psi": psi, "u": u, "v": v, "r": r,
            "udot": ahead * c + aside * s + v * r, "vdot": aside * c - ahead * s - u * r, "rdot": rdot,
            "heave [mm]": frame["heave [mm]"], "X": frame["X [N]"], "Y": frame["Y [N]"], "N": frame["N [Nm]"],
        }  # fmt: skip
        note = f"velocities and accelerations from positions low-passed at {cls.CUTOFF:g} Hz"
        return pd.DataFrame(translation, index=frame.index), (note,)


def rates(t: np.ndarray, position: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity and acceleration of a position, low-passed by a Butterworth filter that runs forward and back."""
    # t (rows,) [s]; position (rows,) [m]; cutoff [Hz]
    from scipy.signal import butter, sosfiltfilt

    if len(t) < SHORTEST_RECORD:
        raise InputError(f"{len(t)} rows are too few to low-pass; give a record of {SHORTEST_RECORD} or more")
    step = np.diff(t)
    if step.min() <= 0 or np.ptp(step) > 0.01 * step.mean():
        raise InputError(f"time steps vary from {step.min():g} to {step.max():g} s; resample the record evenly")
    rate = 1 / step.mean()
    if cutoff >= rate / 2:
        raise InputError(f"a cutoff of {cutoff:g} Hz is not below half the sampling rate {rate:g} Hz; lower it")
    # The filter's transient lasts some periods of its cutoff; SciPy's own padding is shorter and spoils a moving end.
    padding = min(len(position) - 1, round(3 * rate / cutoff))
    # From its begin: the filter makes rounding of a constant, which would count as motion.
    moved = position - position[0]
    velocity = np.gradient(sosfiltfilt(butter(4, cutoff, fs=rate, output="sos"), moved, padlen=padding), t)
    return velocity, np.gradient(velocity, t)


class Fhr(Layout):
    """Flanders Hydraulics Research's tests for SIMMAN: planar motion mechanism, averaged by phase, several depths.

    Their layout: ``env, test, type, x_m, y_m, psi_deg, ...``, one row per phase of a harmonic run or per steady run,
    ``env`` the environment (a water depth), ``rud_given_deg`` the rudder angle. Sinkage stands for heave.
    """

    HEADERS = ("env", "type", "psi_deg", "rud_given_deg")
    # Harmonic sway and harmonic yaw: the tests covered by the paper's terms.
    HARMONIC = ("PMMY2", "PMMPSI2")
    RENAMED: ClassVar = {
        "env": "condition", "sinkage_mm": "heave [mm]", "rud_given_deg": "rudder [deg]",
        "n_meas_rpm": "revolutions [rpm]",
    }  # fmt: skip
    TURNED = (
        "rudder is rud_given_deg with its sign turned, as it counts the other way there: positive turns the bow to port"
    )

    @classmethod
    def translated(cls, frame: pd.DataFrame, chosen: str, table: str) -> Translated:
        # Unless the user's selection names the type of test or the rudder, harmonic tests with the rudder amidships are
        # kept: the paper's terms cover neither a rudder nor a drift of 90 degrees.
        turned = -numbers(frame, "rud_given_deg", table)
        frame = frame.assign(rud_given_deg=turned).rename(columns=cls.RENAMED)
        if re.search(r"\b(?:type|rud_given_deg|rudder\w*)\b", chosen):
            return frame, (cls.TURNED,)
        kept = frame[frame["type"].isin(cls.HARMONIC) & (np.abs(frame["rudder [deg]"]) < 1)]
        return kept, (f"{len(kept)} of {len(frame)} rows read: harmonic sway and yaw with the rudder amidships",)


# Distance of the tank's wall from its centreline [m].
WALL = 3.5
# Distance from the tank's centreline and height above its bottom [m], from the data's table of banks: toe, slope (1/5,
# 1/5, 1/5, 1/8, 1/8, 1/3) and, of III, IV and VI, a platform from the top of the slope to the tank's wall.
BANKS = {
    "I": ((2.83, 0.0), (2.83, 0.5)),
    "II": ((0.53, 0.0), (3.03, 0.5)),
    "III": ((0.53, 0.0), (1.13, 0.12), (WALL, 0.12)),
    "IV": ((0.53, 0.0), (1.28, 0.15), (WALL, 0.15)),
    "V": ((0.53, 0.0), (WALL, 2.97 / 8)),
    "VI": ((0.53, 0.0), (1.73, 0.15), (WALL, 0.15)),
    "VII": ((2.23, 0.0), (WALL, 1.27 / 3)),
}


class Lataire(Layout):
    """The ten steady bank tests of Lataire, Vantorre and Eloot (2009): one row per test, each with its draft and depth.

    The banks are walls, slopes and platforms at starboard of a tank 7 m wide. Each is replaced by the wall with the
    same section at the row's own depth: width and offset refer to the canal between that wall and the tank's own.
    """

    HEADERS = ("lateral position", "psi", "sinkage fore", "sinkage aft", "bank name")
    RENAMED: ClassVar = {
        "short name test": "test", "draught": "draft [m]", "water depth": "depth [m]",
        "forward component of speed vector": "u [m/s]", "transversal component of speed vector": "v [m/s]",
        "lateral position": "y [m]", "psi": "psi [deg]",
        "longitudinal force": "X [N]", "transversal force": "Y [N]", "yaw moment": "N [Nm]",
        "bank name": "bank", "rudder angle": "rudder [deg]",
    }  # fmt: skip

    @classmethod
    def translated(cls, frame: pd.DataFrame, chosen: str, table: str) -> Translated:
        ahead = frame[np.abs(numbers(frame, "psi", table)) < 90].rename(columns=cls.RENAMED)
        fore, aft = (numbers(ahead, f"sinkage {end}", table) for end in ("fore", "aft"))
        ahead["heave [mm]"] = (fore + aft) / 2
        if "propeller rate" in ahead:
            rate = numbers(ahead, "propeller rate", table)
            ahead["revolutions [rpm]"] = np.where(rate == -1, 0.0, rate)  # -1 stands for stopped
        ahead[["r", "udot", "vdot", "rdot"]] = np.zeros((len(ahead), 4))
        ahead["condition"] = "banks"
        for name in ahead["bank"]:
            if name not in BANKS:
                raise InputError(f"{table}: bank {name!r} is not one of {', '.join(BANKS)}; mend it")
        depths = numbers(ahead, "depth [m]", table)
        walls = np.array([wall_of(BANKS[b], h) for b, h in zip(ahead["bank"], depths, strict=True)])
        ahead["y [m]"] = numbers(ahead, "y [m]", table) - (walls - WALL) / 2
        ahead["width [m]"] = walls + WALL
        left = len(frame) - len(ahead)
        note = "slopes and platforms are taken as the wall that leaves the same section; y is from between the walls"
        return ahead, (*[f"{left} of {len(frame)} tests left out: sailed backwards"] * bool(left), note)


# No two recognise the same table, so their order does not matter.
LAYOUTS: tuple[type[Layout], ...] = tuple(Layout.__subclasses__())


def layout_of(frame: pd.DataFrame) -> type[Layout] | None:
    return next((layout for layout in LAYOUTS if layout.recognises(frame)), None)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> Translated:
    """Convert a frame of a known layout to the documented headers, with notes."""
    layout = layout_of(frame)
    return layout.translated(frame, chosen, table) if layout else (frame, ())
