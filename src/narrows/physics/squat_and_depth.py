"""Shallow water: squat, the speed at which a canal chokes, and how hull derivatives grow as the water gets shallow."""

from narrows.quantities.arithmetic import angle, choice, clip, maximum, sine
from narrows.quantities.names import GRAVITY, KNOT, Number

MIDSHIP_SECTION = 0.98  # Midship section over beam times draft, if unknown [1]
TRIMLESS = 0.7  # Block coefficient [1] of a ship without trim: a fuller one sinks most at the bow
BOUNDLESS = 1000.0  # Speed without limit, above that of any ship [m/s]


def depth_froude(u: Number, depth: Number) -> Number:
    """Depth Froude number [1], u/(g h)^(1/2). Source: definition."""
    return u / (GRAVITY * depth) ** 0.5


def blockage(beam: Number, draft: Number, width: Number, depth: Number) -> Number:
    """Share of the canal's section that the ship takes [1], S. Source: definition; midship section of PIANC."""
    return MIDSHIP_SECTION * beam * draft / (width * depth)


def _slender(length: Number, beam: Number, draft: Number, block_coefficient: Number) -> Number:
    """Displaced volume over the square of the length [m]."""
    return block_coefficient * beam * draft / length


def _tuck(u: Number, depth: Number) -> Number:
    """Tuck's number F^2/(1 - F^2)^(1/2) [1]."""
    squared = u * u / (GRAVITY * depth)
    return squared / abs(1 - squared) ** 0.5


def icorels(u: Number, length: Number, beam: Number, draft: Number, block_coefficient: Number, depth: Number) -> Number:
    """Bow sinkage [m] in water without banks. Source: ICORELS (1980), as reviewed by PIANC."""
    fullness = 1.7 if block_coefficient < 0.7 else 2.0 if block_coefficient < 0.8 else 2.4
    return fullness * _slender(length, beam, draft, block_coefficient) * _tuck(u, depth)


def huuska(
    u: Number, length: Number, beam: Number, draft: Number, block_coefficient: Number, width: Number, depth: Number
) -> Number:
    """Bow sinkage [m] in a canal. Source: Huuska (1976) with Guliev's factor for a canal, as reviewed by PIANC."""
    share = blockage(beam, draft, width, depth)
    narrow = 7.45 * share + 0.76 if share > 0.03 else 1.0
    return 2.4 * _slender(length, beam, draft, block_coefficient) * _tuck(u, depth) * narrow


def barrass(u: Number, beam: Number, draft: Number, block_coefficient: Number, width: Number, depth: Number) -> Number:
    """Largest sinkage [m] in a canal. Source: Barrass (2004), Ship design and performance for masters and mates."""
    share = blockage(beam, draft, width, depth)
    narrow = 5.74 * share**0.76 if share >= 0.10 else 1.0
    return narrow * block_coefficient * (u / KNOT) ** 2 / 100


def tuck_midship(
    u: Number, length: Number, beam: Number, draft: Number, block_coefficient: Number, depth: Number
) -> Number:
    """Midship sinkage [m] in water without banks. Source: Tuck (1966) with Hooft's (1974) coefficient."""
    return 1.4 * _slender(length, beam, draft, block_coefficient) * _tuck(u, depth)


def tuck_bow(
    u: Number, length: Number, beam: Number, draft: Number, block_coefficient: Number, depth: Number
) -> Number:
    """Bow sinkage [m] in water without banks. Source: Tuck (1966) with Hooft's (1974) coefficients."""
    q, slender = _tuck(u, depth), _slender(length, beam, draft, block_coefficient)
    trim = slender / length * q
    # The sine of the trim by its series, to 1e-12 below 0.03 rad
    return 1.46 * slender * q + length / 2 * trim * (1 - trim * trim / 6 * (1 - trim * trim / 20))


def critical_speed(beam: Number, draft: Number, width: Number, depth: Number) -> Number:
    """Speed [m/s] at which the return flow chokes a canal, (2 sin(arcsin(1 - S)/3))^(3/2) (g h)^(1/2).

    It solves Schijf's equation 1 - S = 3/2 F^(2/3) - F^2/2 for the depth Froude number exactly. Source: Schijf (1949);
    closed form of Roemisch (1989), verified against Schijf's equation.
    """
    free = 1 - blockage(beam, draft, width, depth)
    arcsine = angle((1 - free**2) ** 0.5, free)
    return (2 * sine(arcsine / 3)) ** 1.5 * (GRAVITY * depth) ** 0.5


def water_past_the_ship(u: Number, beam: Number, draft: Number, width: Number, depth: Number) -> Number:
    """Section of water beside a ship under way, over the section of the canal [1]. Source: Schijf (1949)."""
    # Continuity U w = u and energy U^2 - u^2 = 2 g z, with w = 1 - S - z/h, are w^3 - a w^2 + F^2/2 = 0 with
    # a = 1 - S + F^2/2. Its largest root is the subcritical flow: a/3 (1 + 2 cos(2 t/3)) with sin(t)^2 = 27/8 F^2/a^3.
    half = u * u / (2 * GRAVITY * depth)
    a = 1 - blockage(beam, draft, width, depth) + half
    rising = u * (3.375 / (GRAVITY * depth * (a * a * a))) ** 0.5
    third = sine(angle(abs(1 - rising * rising) ** 0.5, rising) / 3)
    return a - 4 / 3 * a * (third * third)


def return_flow(u: Number, beam: Number, draft: Number, width: Number, depth: Number) -> Number:
    """Speed of the water past a ship less that of the ship [m/s]. Source: Schijf (1949), energy in one dimension."""
    return u / water_past_the_ship(u, beam, draft, width, depth) - u


def continuity(u: Number, beam: Number, draft: Number, width: Number, depth: Number) -> Number:
    """Mean sinkage [m] in a canal, below the critical speed. Source: Schijf (1949), as for ``return_flow``."""
    back = return_flow(u, beam, draft, width, depth)
    return back * (2 * u + back) / (2 * GRAVITY)


def deeper_end(block_coefficient: Number) -> Number:
    """Sinkage of the deeper end over the mean sinkage [1]: the bow of a full ship, the stern of a fine one.

    Source: Barrass (2004), from memory, not verified; within 2 % of the measured mean of the KCS (Lataire 2009).
    """
    return 1 / (1 - 20 * clip(block_coefficient - TRIMLESS, 0.15) ** 2)  # Limited to tested ships


def speed_that_sinks(sinkage: Number, beam: Number, draft: Number, width: Number, depth: Number) -> Number:
    """Speed [m/s] of a mean sinkage [m] in a canal; ``BOUNDLESS`` if it chokes before. Source: Schijf (1949)."""
    past = 1 - blockage(beam, draft, width, depth) - sinkage / depth
    squared = 2 * GRAVITY * sinkage * past**2 / maximum(1 - past**2, 1e-300)
    subcritical = choice(GRAVITY * depth * past**3 - squared, squared**0.5, BOUNDLESS)
    return choice(past * (1 - past), subcritical, BOUNDLESS)


def speed_that_sinks_midship(
    sinkage: Number, length: Number, beam: Number, draft: Number, block_coefficient: Number, depth: Number
) -> Number:
    """Speed through the water [m/s] for a midship sinkage [m] without banks. Source: ``tuck_midship``, inverted."""
    tuck = sinkage / (1.4 * _slender(length, beam, draft, block_coefficient))
    return (GRAVITY * depth * 2 / (1 + (1 + 4 / tuck**2) ** 0.5)) ** 0.5


def _factor(share: Number, power: Number) -> Number:
    """1/(1 - T/h)^n - T/h, for the share T/h; 1 in deep water."""
    return 1 / (1 - share) ** power - share


def kijima_drift_force(beam: Number, draft: Number, block_coefficient: Number, depth: Number) -> Number:
    """Factor on the sway force of drift [1]. Source: Kijima et al. (1990)."""
    return _factor(draft / depth, 0.40 * block_coefficient * beam / draft)


def kijima_drift_moment(beam: Number, draft: Number, block_coefficient: Number, depth: Number) -> Number:
    """Factor on the yaw moment of drift [1]. Source: form of Kijima et al. (1990)."""
    # The exponent is not verified against the text.
    return _factor(draft / depth, 0.425 * block_coefficient * beam / draft)


def kijima_yaw_moment(length: Number, draft: Number, depth: Number) -> Number:
    """Factor on the yaw moment of turning [1]. Source: Kijima et al. (1990); the exponent falls as the draft grows."""
    return _factor(draft / depth, 1.5 - 14.28 * draft / length)
