"""Formulas from main dimensions: the primes of the MMG method with their errors on known ships; propeller and rudder.

All primes follow Yasukawa and Yoshimura (2015): forces over 1/2 rho L d U^2, about midship, of the hull without rudder,
in deep water at even keel. Formulas and derivatives over 1/2 rho L^2 are multiplied by L/T. If a formula includes
the added mass in surge in the turning force, or the mass in everything, these are removed.
The errors of the formulas on known ships, and the constants of banks, are computed by ``decisions/known_ships.py``.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri, stdtrit

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.model.water import ittc57, wetted_surface
from narrows.physics.hull import clarke_sway, clarke_yaw
from narrows.physics.squat_and_depth import kijima_drift_force, kijima_drift_moment, kijima_yaw_moment
from narrows.quantities.names import GRAVITY, Number
from narrows.ship.actuators import Propeller, Rudder
from narrows.ship.particulars import Ship


@dataclass(frozen=True)
class Hull:
    length_to_beam: Number  # L/B
    beam_to_draft: Number  # B/T
    block_coefficient: Number  # C_B
    x_g: Number = 0.0  # Centre of gravity forward of midship over L

    @property
    def slenderness(self) -> Number:
        """T/L."""
        return 1 / (self.length_to_beam * self.beam_to_draft)

    @property
    def fullness(self) -> Number:
        """C_B B/L."""
        return self.block_coefficient / self.length_to_beam

    @property
    def mass(self) -> Number:
        """m' = 2 C_B B/L."""
        return 2 * self.fullness


# Relative sizes of the ships behind the regressions, for the note on ships outside them.
RANGES = {
    "length_to_beam": ("L/B", 5.0, 8.0),
    "beam_to_draft": ("B/T", 2.2, 4.5),
    "block_coefficient": ("C_B", 0.5, 0.87),
}

# Verification of a formula.
AGREE, ALONE = "independent transcriptions agree", "unverified: one transcription"


class Formula(NamedTuple):
    coefficient: str  # Name in the table of terms, or a particular of propeller or rudder
    source: str
    law: Callable[[Hull], Number]
    read: str = AGREE  # Verification, and the reading used if transcriptions disagree


CLARKE = "Clarke, Gedling and Hine (1983)"
ZHOU = "Zhou, Sheng and Feng (1983)"
KIJIMA = "Kijima et al. (1990)"
INOUE = "Inoue, Hirano and Kijima (1981)"
YOSHIMURA = "Yoshimura and Masumoto (2012)"
SMITT = "Wagner Smitt (1971)"
NORRBIN = "Norrbin (1971)"

SURGE_SHARE = 0.05  # Added mass in surge over the mass


def _cross(hull: Hull) -> Number:
    """pi (T/L)^2 per 1/2 rho L^2 U^2, converted to 1/2 rho L d U^2: pi T/L."""
    return math.pi * hull.slenderness


def _norrbin_fullness(hull: Hull) -> Number:
    return hull.block_coefficient * hull.beam_to_draft / math.pi


def _zhou_sway(hull: Hull) -> Number:
    block, ratio, draft = hull.block_coefficient, hull.length_to_beam, 1 / hull.beam_to_draft
    share = (
        0.882
        - 0.54 * block * (1 - 1.6 * draft)
        - 0.156 * (1 - 0.673 * block) * ratio
        + 0.826 * draft * ratio * (1 - 0.678 * draft)
        - 0.638 * block * draft * ratio * (1 - 0.669 * draft)
    )
    return share * hull.mass


def _zhou_yaw(hull: Hull) -> Number:
    block = hull.block_coefficient
    radius = (33 - 76.85 * block * (1 - 0.784 * block) + 3.43 * hull.length_to_beam * (1 - 0.63 * block)) / 100
    return radius**2 * hull.mass


def _clarke_mass(law: Callable[..., Number], hull: Hull) -> Number:
    """Added mass or inertia over 1/2 rho L^2 d or 1/2 rho L^4 d."""
    return law(1.0, 1 / hull.length_to_beam, hull.slenderness, hull.block_coefficient, 2.0) / hull.slenderness


def _aspect(hull: Hull) -> Number:
    return 2 * hull.slenderness


INOUE_YAW = "the square of the aspect ratio is added; one of six transcriptions subtracts it, which contradicts KVLCC2"
WITH_SURGE = "the author counts the added mass in surge with Y_r"

# One row per formula; those of one coefficient are adjacent.
FORMULAS = (
    Formula("X_mx", CLARKE, lambda hull: SURGE_SHARE * hull.mass),
    Formula("X_my", ZHOU, _zhou_sway, "four transcriptions agree; one leaves out C_B in the last term"),
    Formula("X_my", CLARKE, lambda hull: _clarke_mass(clarke_sway, hull)),
    Formula("N_jz", ZHOU, _zhou_yaw, "radius over L; another, divided by L once more, contradicts KVLCC2"),
    Formula("N_jz", CLARKE, lambda hull: _clarke_mass(clarke_yaw, hull), "0.33 B/L; one transcription has 0.0033"),
    Formula("Y_v", CLARKE, lambda hull: -_cross(hull) * (1 + 0.40 * hull.block_coefficient * hull.beam_to_draft)),
    Formula("Y_v", INOUE, lambda hull: -(math.pi / 2 * _aspect(hull) + 1.4 * hull.fullness)),
    Formula("Y_v", SMITT, lambda hull: -1.59 * _cross(hull), ALONE),
    Formula("Y_v", NORRBIN, lambda hull: -_cross(hull) * (1.69 + 0.08 * _norrbin_fullness(hull)), ALONE),
    Formula("Y_r", CLARKE,
            lambda hull: _cross(hull) * (0.5 - 2.2 / hull.length_to_beam + 0.080 * hull.beam_to_draft)
            + SURGE_SHARE * hull.mass,
            f"-0.080 B/T; +0.08 in one of four contradicts KVLCC2; {WITH_SURGE}"),
    Formula("Y_r", KIJIMA, lambda hull: 0.5 * hull.fullness + SURGE_SHARE * hull.mass,
            "m' + m_x' - 1.5 C_B B/L; as in Yoshimura and Masumoto (2012)"),
    Formula("Y_r", INOUE, lambda hull: math.pi / 4 * _aspect(hull), ALONE),
    Formula("Y_r", SMITT, lambda hull: 0.32 * _cross(hull) + SURGE_SHARE * hull.mass, WITH_SURGE),
    Formula("N_v", CLARKE, lambda hull: -_cross(hull) * (0.5 + 2.4 * hull.slenderness)),
    Formula("N_v", INOUE, lambda hull: -_aspect(hull)),
    Formula("N_v", SMITT, lambda hull: -0.62 * _cross(hull), ALONE),
    Formula("N_v", NORRBIN, lambda hull: -_cross(hull) * (0.64 - 0.04 * _norrbin_fullness(hull)), ALONE),
    Formula("N_r", CLARKE,
            lambda hull: -_cross(hull) * (0.25 + 0.039 * hull.beam_to_draft - 0.56 / hull.length_to_beam)),
    Formula("N_r", INOUE, lambda hull: -0.54 * _aspect(hull) + _aspect(hull) ** 2, INOUE_YAW),
    Formula("N_r", SMITT, lambda hull: -0.21 * _cross(hull), ALONE),
    Formula("N_r", NORRBIN, lambda hull: -_cross(hull) * (0.47 - 0.18 * _norrbin_fullness(hull)), ALONE),
    Formula("X_vv", YOSHIMURA, lambda hull: 1.15 * hull.fullness - 0.18),
    Formula("X_vr", YOSHIMURA, lambda hull: 1.91 * hull.fullness - 0.08 - _zhou_sway(hull),
            "- m_y' + 1.91 C_B B/L - 0.08; three of four have the opposite sign, against S-175 and Mariner"),
    Formula("X_rr", YOSHIMURA, lambda hull: -0.085 * hull.fullness + 0.008 - hull.x_g * _zhou_sway(hull)),
    Formula("X_vvvv", YOSHIMURA, lambda hull: -6.68 * hull.fullness + 1.1),
    Formula("Y_vvv", YOSHIMURA, lambda hull: -0.185 * hull.length_to_beam - 0.48,
            "- 0.48; three of four have + 0.48, which contradicts KVLCC2, S-175 and Mariner"),
    Formula("Y_vvr", YOSHIMURA, lambda hull: -0.75),
    Formula("Y_vvr", KIJIMA, lambda hull: 1.5 * hull.block_coefficient / hull.beam_to_draft - 0.65),
    Formula("Y_vrr", YOSHIMURA, lambda hull: -(0.26 * (1 - hull.block_coefficient) * hull.length_to_beam + 0.11)),
    Formula("Y_vrr", KIJIMA, lambda hull: -5.95 * (1 - hull.block_coefficient) / hull.beam_to_draft,
            "T/B; one transcription and its copy have T/T"),
    Formula("Y_rrr", YOSHIMURA, lambda hull: -0.051),
    Formula("Y_rrr", "Lee and Shin (1998)",
            lambda hull: (-0.0233 * hull.block_coefficient / hull.beam_to_draft + 0.0063) / hull.slenderness,
            "-0.0233; one transcription and its copy have -0.233, far from KVLCC2"),
    Formula("N_vvv", YOSHIMURA, lambda hull: 0.69 * hull.block_coefficient - 0.66),
    Formula("N_vvr", YOSHIMURA, lambda hull: 1.55 * hull.fullness - 0.76),
    Formula("N_vvr", KIJIMA, lambda hull: -(57.5 * hull.fullness**2 - 18.4 * hull.fullness + 1.6)),
    Formula("N_vrr", YOSHIMURA, lambda hull: -0.075 * (1 - hull.block_coefficient) * hull.length_to_beam + 0.098,
            "+ 0.098; three of four have - 0.098, which contradicts KVLCC2 and S-175"),
    Formula("N_rrr", YOSHIMURA, lambda hull: 0.25 * hull.fullness - 0.056),
)  # fmt: skip

# Growth of primes from deep water to h/T, by coefficient; missing ones are constant.
# Li and Wu (1990); unverified: the only transcription has 0.129, but the KCS data fit 0.0129.


def _li_wu(hull: Hull, depth_to_draft: Number, slope: float, curve: float) -> Number:
    free = (depth_to_draft - 1) ** 0.82
    return 1 + (0.413 + slope * hull.beam_to_draft + curve * hull.beam_to_draft**2) / free


DEPTH_LAWS: dict[str, Callable[[Hull, Number], Number]] = {
    "X_my": lambda hull, ratio: _li_wu(hull, ratio, 0.032, 0.0129),
    "N_jz": lambda hull, ratio: _li_wu(hull, ratio, 0.0192, 0.00554),
    "Y_v": lambda hull, ratio: kijima_drift_force(hull.beam_to_draft, 1.0, hull.block_coefficient, ratio),
    "N_v": lambda hull, ratio: kijima_drift_moment(hull.beam_to_draft, 1.0, hull.block_coefficient, ratio),
    "N_r": lambda hull, ratio: kijima_yaw_moment(1 / hull.slenderness, 1.0, ratio),
}


def depth_factor(coefficient: str, hull: Hull, depth_to_draft: float) -> float:
    """Return the factor of a prime relative to deep water [1]."""
    law = DEPTH_LAWS.get(coefficient)
    return float(law(hull, depth_to_draft)) if law and math.isfinite(depth_to_draft) else 1.0


# Coefficients of known sign: their errors are factors.
SIGNED = ("X_mx", "X_my", "N_jz", "Y_v", "Y_r", "N_v", "N_r", "Y_vvv", "Y_vrr", "N_vvr", "N_rrr")
COEFFICIENTS = tuple(dict.fromkeys(formula.coefficient for formula in FORMULAS))


class Uncertain(NamedTuple):
    value: float
    std: float


def tail_factor(degrees: float) -> float:
    """Return the 97.5 % quantile of Student's t over that of the normal distribution."""
    return float(stdtrit(degrees, 0.975) / ndtri(0.975))


class FormulaErrors(NamedTuple):
    """Errors of the formulas of one coefficient on the known ships: of logarithms for one of known sign."""

    weights: Sequence[float]  # Weights of the formulas in their mean
    bias: float
    variance: float  # About the bias, over the square of the scale
    degrees: float  # Degrees of freedom of that variance
    scale: float  # 1 for logarithms; the usual size of the coefficient for absolute errors
    by_depth: float  # Variance of the logarithm per T/(h - T), in addition to the depth laws


@dataclass(frozen=True)
class Calibration:
    errors: Mapping[str, FormulaErrors]  # By coefficient
    correlation: np.ndarray  # Correlation matrix of the errors of the signed coefficients

    def estimate(self, name: str, hull: Hull, depth_to_draft: float = math.inf) -> Uncertain:
        """Return a prime of a hull at a depth, with its standard deviation."""
        errors, signed, weights = self.errors[name], name in SIGNED, np.array(self.errors[name].weights)
        values = np.array([float(formula.law(hull)) for formula in FORMULAS if formula.coefficient == name])
        numbers = np.log(np.abs(values)) if signed else values
        mean = float(numbers @ weights)
        size = 1.0 if signed else max(errors.scale, abs(mean))
        variance = errors.variance * size**2 * (1 + 1 / errors.degrees)
        # The formulas' disagreement on this hull is added.
        variance += float(weights @ (numbers - mean) ** 2)
        widened = math.sqrt(variance) * tail_factor(errors.degrees)
        if not signed:
            return Uncertain(mean + errors.bias, widened)
        if math.isfinite(depth_to_draft):
            widened = math.hypot(widened, math.sqrt(errors.by_depth / (depth_to_draft - 1)))
        value = math.copysign(math.exp(mean + errors.bias), values[0]) * depth_factor(name, hull, depth_to_draft)
        return Uncertain(value, widened * abs(value))


def read_calibration() -> Calibration:
    tables = json.loads(Path(__file__).with_name("calibration.json").read_text(encoding="utf-8"))
    errors = {name: FormulaErrors(**row) for name, row in tables["errors"].items()}
    return Calibration(errors, np.array(tables["correlation"]))


# Form of the bank force of the evidence; suction and cushion of a ship without bank tests; the widths and the least
# clearance of the evidence over the beam: by ``decisions/bank_evidence.py``.
FORM = "distance"
BANK_PRIOR = {"Y_bank": Uncertain(0.0986855111, 0.289029546), "N_bank": Uncertain(0.140856833, 0.126160067)}
EVIDENCE_WIDTHS, LEAST_CLEARANCE = (8.0, 12.2), 0.2


VISCOSITY = 1.19e-6  # Kinematic viscosity of sea water at 15 degrees [m2/s]
LARGEST_FROUDE = 0.35  # Beyond it wave resistance dominates, which is not estimated


class ShipType(NamedTuple):
    words: str
    block_coefficient: float
    length_to_beam: float
    beam_to_draft: float
    froude: float  # Service speed over (g L)^(1/2)
    propeller: float  # Propeller diameter over draft
    rudder_area: float  # Rudder area over length times draft
    thrust: tuple[float, float, float]  # K_T = k_0 + k_1 J + k_2 J^2


# K_T of KVLCC2 for full ships, of S-175 for slender ones; sizes of KVLCC2, KCS, DTC and S-175.
FULL, SLENDER = (0.2931, -0.2753, -0.1385), (0.527, -0.455, 0.0)
ASPECT_RATIO = 1.8  # Height squared over area of a rudder

SHIP_TYPES = MappingProxyType({
    "container": ShipType("container ship", 0.65, 7.0, 3.3, 0.20, 0.62, 0.018, SLENDER),
    "tanker": ShipType("tanker", 0.82, 5.6, 2.7, 0.142, 0.48, 0.0168, FULL),
    "bulk": ShipType("bulk carrier", 0.83, 6.2, 2.6, 0.15, 0.50, 0.0165, FULL),
    "general": ShipType("general cargo ship", 0.70, 6.5, 2.6, 0.19, 0.60, 0.018, SLENDER),
    "inland": ShipType("inland motor ship", 0.88, 9.6, 3.5, 0.13, 0.55, 0.030, FULL),
    "convoy": ShipType("pushed convoy", 0.92, 8.3, 6.5, 0.10, 0.55, 0.045, FULL),
})  # fmt: skip


def service_speed(ship: Ship, kind: ShipType) -> float:
    """Return the design speed of the propeller [m/s]."""
    return kind.froude * math.sqrt(GRAVITY * ship.length)


def resistance_prime(ship: Ship, speed: float) -> float:
    """Return R_0' over 1/2 rho L T: ITTC-57 with Watanabe's form factor, Mumford's wetted surface, an allowance."""
    most = LARGEST_FROUDE * math.sqrt(GRAVITY * ship.length)
    if not 0 < speed <= most:
        raise InputError(f"a speed of {speed:.4g} m/s is none of this ship; give one over 0 and up to {most:.3g} m/s")
    ratio, draft = ship.length / ship.beam, ship.beam / ship.draft
    friction = ittc57(speed * ship.length / VISCOSITY)
    form = -0.095 + 25.6 * ship.block_coefficient / (ratio**2 * math.sqrt(draft))
    # The correlation allowance and the residual resistance are 0.0004 over the wetted surface.
    return ((1 + form) * friction + 0.0004) * wetted_surface(ship) / (ship.length * ship.draft)


def thrust_deduction(hull: Hull) -> float:
    """Return t_P: Harvald's line for single-screw ships."""
    return 0.25 * wake(hull) + 0.14


def wake(hull: Hull) -> float:
    """Return w_P0: Taylor's 0.5 C_B - 0.05."""
    return 0.5 * float(hull.block_coefficient) - 0.05


RUDDER_SURGE = 0.61  # 1 - t_R, Yoshimura and Masumoto (2012); KVLCC2 has 0.613
RUDDER_PLACE, INCREASE_PLACE = 0.5, 0.45  # -x_R', -x_H' [1]; x_H' of Aoki et al. (2006)


def estimated_rudder(ship: Ship, hull: Hull, kind: ShipType, propeller: Propeller) -> Rudder:
    """Return a rudder of usual size, in the slipstream by Yoshimura and Masumoto (2012)."""
    area = kind.rudder_area * ship.length * ship.draft
    ratio = 2.26 - 1.82 * (1 - propeller.wake)
    straightening = 2.06 * float(hull.fullness) + 0.14
    return Rudder(
        area=area,
        lift=6.13 * ASPECT_RATIO / (ASPECT_RATIO + 2.25),
        wake_ratio=ratio,
        slipstream=0.55 / ratio,
        in_slipstream=min(propeller.diameter / math.sqrt(ASPECT_RATIO * area), 1.0),
        position=-0.9,  # l_R', Yoshimura and Masumoto (2012)
        straightening_starboard=straightening,
        straightening_port=straightening,
    )


def estimated_propeller(ship: Ship, hull: Hull, kind: ShipType, speed: float) -> Propeller:
    """Return a propeller of usual size, with revolutions whose thrust balances the resistance at a speed."""
    thinned = 1 / (1 - wake(hull))
    # C_1 = 1.6 matches Hirano's (1980) exp(-4 beta_P^2) at a drift of 0.4 rad at the propeller, as in a turn.
    shaped = Propeller(
        kind.propeller * ship.draft, 0.0, wake(hull), *kind.thrust,
        wake_rate=1.6, wake_starboard=thinned, wake_port=thinned,
    )  # fmt: skip
    return with_astern_thrust(replace(shaped, revolutions=balanced_revolutions(ship, hull, shaped, speed)))


# Thrust of the Wageningen B4-70 series at the pitch ratios 0.6, 0.8, 1 and 1.2: K_T ahead without advance, and a_0, a_1
# and a_2 of K_T astern for k_2 = 0. SQUARE fits J^2 by the same functions (``decisions/propeller_series.py``).
SERIES = np.array([
    [0.2421, 0.3461, 0.4499, 0.5193], [0.959, 0.924, 0.962, 1.036], [-0.488, -0.504, -0.650, -0.772],
    [-1.633, -1.706, -1.906, -2.131],
])  # fmt: skip
SQUARE = (-2.386, 0.865, 3.525)


@accept_aliases
def with_astern_thrust(propeller: Propeller) -> Propeller:
    """Return a propeller with the thrust astern of the Wageningen B4-70 series, at the pitch of its thrust ahead.

    The pitch ratio is that at which the series has the same K_T without advance; beyond 0.6 and 1.2 the nearest counts.
    For advances J from -1.5 to 0 the fit is within 0.06 of the series' K_T.

    Source: Roddy, Hess and Faller (2006), Neural network predictions of the 4-quadrant Wageningen propeller series,
    NSWCCD-50-TR-2006/004.

    Parameters
    ----------
    propeller : Propeller
        A propeller whose thrust ahead is known.

    Examples
    --------
    >>> nw.with_astern_thrust(nw.Propeller(9.86, 1.78, 0.35, 0.2931, -0.2753, -0.1385)).astern_0
    0.6114
    """
    fits = (np.interp(propeller.thrust_0, SERIES[0], column) for column in SERIES[1:])
    found = (round(float(fit) - propeller.thrust_2 * part, 4) for fit, part in zip(fits, SQUARE, strict=True))
    return replace(propeller, **dict(zip(("astern_0", "astern_1", "astern_2"), found, strict=True)))


def balanced_revolutions(ship: Ship, hull: Hull, propeller: Propeller, speed: float) -> float:
    needed = resistance_prime(ship, speed) * 0.5 * ship.length * ship.draft * speed**2 / (1 - thrust_deduction(hull))
    inflow, size = speed * (1 - propeller.wake), propeller.diameter
    # thrust/rho = D^4 k_0 n^2 + D^3 k_1 u n + D^2 k_2 u^2
    square, linear = size**4 * propeller.thrust_0, size**3 * propeller.thrust_1 * inflow
    rest = size**2 * propeller.thrust_2 * inflow**2 - needed
    return (-linear + math.sqrt(linear**2 - 4 * square * rest)) / (2 * square)
