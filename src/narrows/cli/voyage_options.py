"""Groups of options of ``simulate`` and ``map``: start, forces, helm, time, physics, water."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import radians
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

import narrows as nw
from narrows.cli.options import Numbers, Option, Speed, Speeds, WaterwayFile, numbers
from narrows.cli.options import speed as read_speed
from narrows.errors import InputError, check_choice

if TYPE_CHECKING:
    from narrows.simulation.initial_state import VoyageDefaults

HELMS = ("regulator", "predictive")
ContactKind = Annotated[
    str, Option(help="Contact with the bank: hull 'corners', 'midship' clearance, or 'none' in open water.")
]


@dataclass(frozen=True)
class StartOptions:
    y: Annotated[float, Option(help="Start to starboard of the centreline [m].")] = 0.0
    speed: Annotated[
        Speed | None, Option(help="Surge velocity: 1.2m/s, 8kn; m/s without a unit; default: one that suits the ship.")
    ] = None
    psi_deg: Annotated[float, Option(help="Heading at the start [deg].")] = 0.0
    v: Annotated[Speed, Option(help="Sway velocity at the start, likewise.")] = "0m/s"
    r_deg: Annotated[float, Option(help="Yaw rate at the start [deg/s].")] = 0.0
    x: Annotated[float, Option(help="Start along the canal [m].")] = 0.0
    revolutions: Annotated[float | None, Option(help="Propeller revolutions [1/s]; default: those of the model.")] = (
        None
    )

    def values(self) -> dict[str, float]:
        turning = {"psi": radians(self.psi_deg), "r": radians(self.r_deg)}
        turns = {} if self.revolutions is None else {"revolutions": self.revolutions}
        return {"x": self.x, "y": self.y, "v": self.v, **turning, **turns}


@dataclass(frozen=True)
class PushOptions:
    surge_force: Annotated[float, Option("--X", help="External surge force [N].")] = 0.0
    sway_force: Annotated[float, Option("--Y", help="External sway force [N].")] = 0.0
    yaw_moment: Annotated[float, Option("--N", help="External yaw moment [N m].")] = 0.0

    def values(self) -> dict[str, float]:
        return {"X": self.surge_force, "Y": self.sway_force, "N": self.yaw_moment}


@dataclass(frozen=True)
class HelmOptions:
    rudder_deg: Annotated[
        float, Option(help="Rudder angle [deg], positive to starboard; for models with a rudder.")
    ] = 0.0
    hold: Annotated[float | None, Option(help="Offset held by a helm [m], for models with a rudder.")] = None
    controller: Annotated[str | None, Option(help="Helm: regulator or predictive.")] = None

    def of(self, model: "nw.Model", u: float, x: float, way: "nw.Waterway | None") -> Any:
        """Return the helm for the model's own canal, or for the section of a waterway at the ship's start."""
        if self.controller is not None:
            check_choice("--controller", self.controller, HELMS)
        if self.hold is None:
            if self.controller is not None:
                raise InputError("--controller needs the offset that it holds: add --hold, or leave it out")
            return None
        if self.controller == "predictive":
            from narrows.control.predictive import PredictiveHelm

            return PredictiveHelm(model, self.hold, u, way)
        from narrows.control.regulator import regulator

        return regulator(model, self.hold, u, waterway=way, at=0.0 if way is None else x)


@dataclass(frozen=True)
class TimeOptions:
    duration: Annotated[
        float | None, Option(help="Longest duration of a voyage [s]; default: the time of 15 ship lengths.")
    ] = None
    dt: Annotated[float | None, Option(help="Time step [s]; default: a 200th of the time of a ship length.")] = None


@dataclass(frozen=True)
class PhysicsOptions:
    surge: Annotated[str, Option(help="'held': constant speed; 'free': it is integrated.")] = "held"
    surge_inertia: Annotated[float | None, Option(help="Mass in surge with its added mass [kg], for 'free'.")] = None
    coriolis: Annotated[bool, Option("--coriolis", help="Add the rigid body's Coriolis force.")] = False
    contact: ContactKind = "corners"


def read_current(
    option: str, text: str, read: Callable[[str, str], float] = read_speed
) -> "float | list[tuple[float, float]]":
    """Read the speed of a current [m/s], or pairs of a place [m] and the speed there: ``0:0.4m/s,2000:1m/s``."""
    if ":" not in text:
        return read(option, text)
    pairs = [pair.partition(":") for pair in text.split(",")]
    return [(_number(option, place), read(option, number)) for place, _, number in pairs]


def _number(option: str, text: str) -> float:
    return float(numbers(option, text)[0])


Current = Annotated[Any, read_current]
Shear = Annotated[Any, partial(read_current, read=_number)]
CurrentText = Annotated[
    Current, Option(help="Current along the waterway at its beginning: 0.5m/s, 1kn; or 0:0.5m/s,900:1m/s.")
]


@dataclass(frozen=True)
class WaterOptions:
    waterway: WaterwayFile = None
    current: CurrentText = None
    level: Annotated[float | None, Option(help="Water level above that of the waterway's depths [m].")] = None
    current_across: Annotated[Current, Option(help="Current to starboard of the line, likewise.")] = None
    current_shear: Annotated[
        Shear, Option(help="Rise of the current along for each metre to starboard [1/s]: 0.002; or 0:0.001,900:0.")
    ] = None

    def read(self) -> "nw.Waterway | None":
        water = (self.current, self.level, self.current_across, self.current_shear)
        if self.waterway is None:
            if any(own is not None for own in water):
                raise InputError(
                    "--current, --current-across, --current-shear and --level are a waterway's; add --waterway, or "
                    "leave them out"
                )
            return None
        return nw.read_waterway(self.waterway).with_water(*water)


@dataclass(frozen=True)
class VariedOptions:
    y: Annotated[
        Numbers | None,
        Option(help="Start to starboard [m]: a number, a,b,c or from:to:count; bank to bank unless given."),
    ] = None
    speed: Annotated[
        Speeds | None,
        Option(help="Surge velocity: 8kn, 4kn:8kn:5, 1.2m/s; m/s without a unit; default: one that suits the ship."),
    ] = None
    psi_deg: Annotated[Numbers, Option(help="Heading at the start [deg], likewise.")] = "0"
    width: Annotated[Numbers | None, Option(help="Canal width [m], likewise; default: the model's own.")] = None
    x: Annotated[Numbers, Option(help="Start along the waterway [m], likewise.")] = "0"

    def values(self, defaults: "VoyageDefaults", offsets: int) -> dict[str, Any]:
        aside = np.linspace(-defaults.offset, defaults.offset, offsets)
        vary = {
            "y": aside if self.y is None else self.y,
            "u": np.array([defaults.speed]) if self.speed is None else self.speed,
            "psi": radians(1) * self.psi_deg, "x": self.x, **({} if self.width is None else {"width": self.width}),
        }  # fmt: skip
        return {name: values if values.size > 1 else float(values[0]) for name, values in vary.items()}


@dataclass(frozen=True)
class SampleOptions:
    samples: Annotated[int, Option(help="Number of coefficient samples from the fit's covariance.")] = 0
    within: Annotated[
        float | None, Option(help="With --samples: map the probability of grounding within this distance [m].")
    ] = None
    seed: Annotated[int, Option(help="Seed of the samples.")] = 0

    def __post_init__(self) -> None:
        if self.within is not None and not 0 < self.within < float("inf"):
            raise InputError(f"--within {self.within} is no distance; give metres")
        if self.within is not None and not self.samples:
            raise InputError("--within maps a probability, which needs samples of the coefficients: add --samples 200")
