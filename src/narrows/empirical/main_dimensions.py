"""A model from checked main dimensions: hull, propeller, rudder by formulas, banks from other ships, and errors."""

import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_choice, shown
from narrows.base.named_values import Coefficients
from narrows.empirical import formulas
from narrows.empirical.formulas import SHIP_TYPES, SIGNED, Calibration, Hull, ShipType, Uncertain
from narrows.model.data_range import DataRange
from narrows.model.model import Model
from narrows.model.sections import Source
from narrows.model.tables import table_named
from narrows.quantities.names import GRAVITY, KNOT
from narrows.ship.actuators import Propeller, Rudder, SteeringGear
from narrows.ship.checks import check_number, is_finite
from narrows.ship.particulars import Canal, Configuration, Ship, Water

TABLE = f"mmg+{formulas.FORM}"
SEA = Water(1025.0)
ALL_SHIPS = formulas.read_calibration()

# Relative standard deviations of parts that no known ship calibrates, from the differences between the formulas, KVLCC2
# and S-175.
RUDDER_SHARE = 0.20  # Whole rudder force: wake, slipstream, straightening
INCREASE_SHARE = 0.10  # 1 + a_H in addition
RESISTANCE_SHARE = 0.30
THRUST_SHARE = 0.06

SHALLOWEST, DEEPEST = 1.2, 1e3  # h/T of the calibration; beyond it the water is deep
DEEP = 3.0  # h/T from which water counts as deep for manoeuvring, PIANC (1992), by Vantorre et al. (2017)
# Share by which the clearance below the keel may differ from that of the estimate: the laws of depth have its power
# -0.82, so coefficients change by 16 %.
NEAR_DEPTH = 0.2
NEEDED = ("length", "beam", "draft", "block_coefficient")


@accept_aliases
def estimate_model(
    ship: Ship | Mapping[str, Any], canal: Canal, water: Water = SEA, *, kind: str | None = None,
    speed: float | None = None, propeller: Propeller | None = None, rudder: Rudder | None = None,
    steering: SteeringGear | None = None, calibration: Calibration | None = None,
) -> Model:  # fmt: skip
    """Estimate the model of a ship from its main dimensions, with the errors of the formulas on known ships.

    The terms are those of the MMG standard method with the bank term of Vantorre et al. (2003). The covariance contains
    the errors of the formulas on ships with known derivatives, and their disagreement; the bank's coefficients are
    those of ships tested along banks. ``model.notes`` lists the assumed values. Raises an InputError if
    a value is missing, unrealistic or of another unit, or the ship does not fit in the canal.

    Parameters
    ----------
    ship : Ship or mapping
        length, beam, draft [m] and block_coefficient; a mapping may lack beam, draft and block_coefficient if ``kind``
        is given.
    canal : Canal
        The canal; the derivatives are estimated for its depth, or for deep water.
    water : Water
        Default: sea water.
    kind : str, optional
        container, tanker, bulk, general, inland or convoy: gives usual values for missing ones.
    speed : float [m/s], optional
        Service speed for the propeller's revolutions; usual for the kind unless given.
    propeller, rudder, steering : Propeller, Rudder, SteeringGear, optional
        Estimated if not given; the default gear is that of the rules.
    calibration : Calibration, optional
        Errors of the formulas; those on all known ships unless given.

    Examples
    --------
    >>> import narrows as nw
    >>> ship = nw.Ship(length=366, beam=51, draft=15, block_coefficient=0.65)
    >>> model = nw.estimate_model(ship, nw.Canal(300, 18))
    >>> model.terms.name
    'mmg+distance'
    """
    if isinstance(ship, Model):
        raise InputError("estimate_model takes main dimensions; nw.estimate_states(model, log) estimates states")
    calibration = calibration or ALL_SHIPS
    parts = {"propeller": propeller, "rudder": rudder, "steering": steering}
    check_types(ship, canal, water, **parts)
    known, filled = _completed(ship, kind)
    check_proportions(known, water, parts)
    usual = SHIP_TYPES[kind or ("container" if known.block_coefficient < 0.72 else "tanker")]
    hull = hull_of(known)
    known = _with_mass(known, water)
    configuration = Configuration(known, canal, water, steering=steering)
    service = formulas.service_speed(known, usual) if speed is None else speed
    check_speed(service, known, usual)
    resistance = formulas.resistance_prime(known, service)
    driven = propeller or formulas.estimated_propeller(known, hull, usual, service)
    steered = rudder or formulas.estimated_rudder(known, hull, usual, driven)
    depth_to_draft = canal.depth / known.draft if canal.depth else math.inf
    spreads = {name: calibration.estimate(name, hull, depth_to_draft) for name in formulas.COEFFICIENTS}
    spreads |= formulas.BANK_PRIOR
    spreads["R_0"] = Uncertain(resistance, RESISTANCE_SHARE * resistance)
    coefficients, covariance = _assembled(spreads, hull, calibration.correlation)
    missing = [name for name in ("propeller", "rudder") if parts[name] is None]
    words = f"{'an' if usual.words[0] in 'aeiou' else 'a'} {usual.words}{'' if kind else ', by the block coefficient'}"
    return Model(
        replace(configuration, propeller=driven, rudder=steered),
        table_named(TABLE),
        Coefficients(coefficients),
        covariance=covariance,
        data_range=DataRange(
            speed=(0.0, 0.25 * math.sqrt(GRAVITY * known.length)),  # Tests behind the formulas were no faster
            depth_to_draft=_depths_of(depth_to_draft),
            width_to_beam=formulas.EVIDENCE_WIDTHS,
            abs_y=(0.0, max(canal.width / 2 - (0.5 + formulas.LEAST_CLEARANCE) * known.beam, 0.0)),
        ),
        source=Source(
            text="formulas of the literature, calibrated on ships whose derivatives are known",
            estimate=" ".join(_sentences(known, filled, missing, words, service, hull, depth_to_draft)),
        ),
        verdicts=dict.fromkeys(formulas.BANK_PRIOR, "estimated from other ships"),
    )


def _depths_of(depth_to_draft: float) -> tuple[float, float]:
    """Return the h/T for which coefficients of one h/T serve: those about it, or deep water."""
    if math.isinf(depth_to_draft):
        return DEEP, DEEPEST
    least, most = (1 + (1 + sign * NEAR_DEPTH) * (depth_to_draft - 1) for sign in (-1, 1))
    return max(SHALLOWEST, least), max(SHALLOWEST, most if depth_to_draft < DEEP else DEEPEST)


def hull_of(ship: Ship) -> Hull:
    return Hull(
        ship.length / ship.beam, ship.beam / ship.draft, ship.block_coefficient, (ship.x_g or 0.0) / ship.length
    )


def _completed(ship: Ship | Mapping[str, Any], kind: str | None) -> tuple[Ship, list[str]]:
    """Return the ship with usual values of its kind for missing ones, and a list of these."""
    if kind is not None:
        check_choice("kind", kind, SHIP_TYPES)
    if isinstance(ship, Ship):
        return ship, []
    given = {name: value for name, value in ship.items() if value is not None}
    if "length" not in given:
        raise InputError("the ship has no length; give length between perpendiculars, in metres")
    missing = [name for name in NEEDED if name not in given]
    if missing and kind is None:
        words = ", ".join(name.replace("_", " ") for name in missing)
        those = "it" if len(missing) == 1 else "them"
        raise InputError(f"the ship has no {words}; give {those}, or a kind of ship: {', '.join(SHIP_TYPES)}")
    for name in set(given) & set(NEEDED):
        check_number(f"[ship] {name}", given[name])
    if not missing:
        return Ship(**given), []
    usual = SHIP_TYPES[str(kind)]
    beam = given.get("beam", given["length"] / usual.length_to_beam)
    sizes = {"beam": beam, "draft": beam / usual.beam_to_draft, "block_coefficient": usual.block_coefficient}
    given = sizes | given
    filled = [f"{name.replace('_', ' ')} {given[name]:.3g}{' m' * (name != 'block_coefficient')}" for name in missing]
    return Ship(**given), filled


def _with_mass(ship: Ship, water: Water) -> Ship:
    # The radius of gyration is 0.25 L, Yasukawa and Yoshimura (2015) for KVLCC2; 0.25 to 0.27 is usual.
    x_g = ship.x_g or 0.0
    mass = ship.mass or water.density * ship.block_coefficient * ship.length * ship.beam * ship.draft
    inertia = ship.inertia or mass * ((0.25 * ship.length) ** 2 + x_g**2)
    return replace(ship, mass=mass, inertia=inertia, x_g=x_g)


def _assembled(
    spreads: Mapping[str, Uncertain], hull: Hull, correlation: np.ndarray
) -> tuple[dict[str, float], np.ndarray]:
    """Return coefficients and covariance in the order of the terms; tied coefficients share one error."""
    terms = table_named(TABLE)
    # 1 + a_H: geometric mean of Yoshimura and Masumoto (2012) and Quadvlieg (2013)
    increase = 1 + math.sqrt(3.6 * hull.fullness * max(0.627 * hull.block_coefficient - 0.153, 0.05))
    lever = formulas.RUDDER_PLACE + (increase - 1) * formulas.INCREASE_PLACE
    values = {
        "X_mass": 1.0, "X_thrust": 1 - formulas.thrust_deduction(hull), "X_rudder": formulas.RUDDER_SURGE,
        "Y_rudder": increase, "N_rudder": lever, **{name: spread.value for name, spread in spreads.items()},
    }  # fmt: skip
    errors: list[Mapping[str, float]] = [{name: spread.std} for name, spread in spreads.items() if name not in SIGNED]
    root = np.linalg.cholesky(correlation)
    errors += [
        {name: spreads[name].std * root[row, column] for row, name in enumerate(SIGNED)}
        for column in range(len(SIGNED))
    ]
    rudder = ("X_rudder", "Y_rudder", "N_rudder")
    errors += [
        {name: RUDDER_SHARE * values[name] for name in rudder},
        {"Y_rudder": INCREASE_SHARE * increase, "N_rudder": INCREASE_SHARE * increase * formulas.INCREASE_PLACE},
        {"X_thrust": THRUST_SHARE * values["X_thrust"]},
    ]
    tied = {other: one for one, other in terms.ties}
    table = np.array([[error.get(tied.get(name, name), 0.0) for error in errors] for name in terms.names])
    return {name: values[tied.get(name, name)] for name in terms.names}, table @ table.T


def _sentences(
    ship: Ship, filled: list[str], parts: list[str], usual: str, service: float, hull: Hull, depth_to_draft: float
) -> list[str]:
    sentences = [
        f"The model is estimated from main dimensions ({ship.length:.4g} x {ship.beam:.4g} x {ship.draft:.4g} m, block "
        f"coefficient {ship.block_coefficient:.3g}), not from tests of this ship."
    ]
    if filled:
        sentences.append(f"Usual values of {usual}: {', '.join(filled)}.")
    if parts:
        sentences.append(
            f"The {' and '.join(parts)} are those of {usual}, for {service:.3g} m/s ({service / KNOT:.3g} knots)."
        )
    ratios = asdict(hull)
    outside = [
        f"{words} {ratios[name]:.3g} ({low:g} to {high:g})"
        for name, (words, low, high) in formulas.RANGES.items()
        if not low <= ratios[name] <= high
    ]
    if outside:
        sentences.append(f"Outside the ships behind the formulas: {', '.join(outside)}.")
    if depth_to_draft < SHALLOWEST:
        sentences.append(f"h/T {depth_to_draft:.3g} is less than that of any known ship ({SHALLOWEST:g}).")
    return sentences


def check_types(ship: object, canal: object, water: object, **parts: object) -> None:
    if not isinstance(ship, Ship | Mapping):
        raise InputError(f"ship = {shown(ship)} is no ship; give nw.Ship(length, beam, draft, block_coefficient)")
    types = {"canal": Canal, "water": Water, "propeller": Propeller, "rudder": Rudder, "steering": SteeringGear}
    for name, value in {"canal": canal, "water": water, **parts}.items():
        if not isinstance(value, types[name]) and not (name in parts and value is None):
            raise InputError(f"{name} = {shown(value)} is of another type; give nw.{types[name].__name__}(...)")


def check_speed(speed: Any, ship: Ship, kind: ShipType) -> None:
    if not is_finite(speed):
        raise InputError(f"a service speed of {shown(speed)} is not a finite number; give it in m/s")
    ordinary = formulas.service_speed(ship, kind)
    if speed > 1.8 * ordinary:  # A speed in knots is 1.94 times that in m/s
        raise InputError(
            f"a service speed of {speed:.4g} m/s is {speed / ordinary:.2g} times that of a usual {kind.words} of this "
            f"length, {ordinary:.3g} m/s; numbers are m/s, and {speed:.4g} knots are {speed * KNOT:.3g} m/s"
        )


def check_proportions(ship: Ship, water: Water, parts: Mapping[str, Any]) -> None:
    """Raise if a particular is out of proportion to the ship: another unit, a share, or two of them exchanged."""
    displaced = water.density * ship.block_coefficient * ship.length * ship.beam * ship.draft
    mass, pace = ship.mass or displaced, math.sqrt(GRAVITY * ship.length)
    diameter, wrong = getattr(parts["propeller"], "diameter", 1.0), "check the dimensions and units"
    # The size that each is compared with, in words, the widest range of their ratio (no wrong unit), and a remedy.
    sizes = (
        ("ship length", 1.0, "m", 1.0, 500.0, "give metres, not feet, millimetres or kilometres"),
        ("ship length", ship.beam, "times the beam", 2.5, 15.0, wrong),
        ("ship beam", ship.draft, "times the draft", 1.2, 15.0, wrong),
        # At a block coefficient of 1 some formulas have no value.
        ("ship block_coefficient", 1.0, "of L x B x T", 0.3, 0.98, wrong),
        ("ship mass", displaced, "times the displaced water", 0.7, 1.4, "give it in kg"),
        ("ship inertia", mass * ship.length**2, "times mass x length^2", 0.02, 0.2, "give it in kg m2"),
        ("ship x_g", ship.length, "times the length", -0.1, 0.1, "give metres forward of midship"),
        ("propeller diameter", ship.draft, "times the draft", 0.15, 1.2, "give it in metres"),
        ("propeller revolutions", pace / diameter, "times (g L)^(1/2) over the diameter", 0.0, 1.5,
         "give revolutions per second, not per minute"),
        ("rudder area", ship.length * ship.draft, "times L x T", 0.005, 0.1, "give it in m2, not as a share"),
        ("steering limit_deg", 35.0, "times the usual 35 degrees", 0.1, 2.6, "give degrees, not radians"),
    )  # fmt: skip
    for place, size, words, low, high, remedy in sizes:
        section, key = place.split()
        value = getattr({"ship": ship, **parts}[section], key, None)
        if value is not None and not low * size <= value <= high * size:
            raise InputError(
                f"[{section}] {key} = {value:.4g} is {value / size:.3g} {words}, outside {low:g} to {high:g}; {remedy}"
            )
