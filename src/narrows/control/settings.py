"""Numbers of the helms that one may want to change; times are in times of a ship length, rates in its inverse."""

import math

import numpy as np

# Bryson's rule: heading and rudder off the course [rad] that weigh as much as half a beam off the line. The first pair
# is the calmest helm; a regulator takes the first that holds nearly all ships, the track pilot always the first.
WEIGHT_LADDER = tuple(
    (math.radians(heading), math.radians(rudder)) for heading, rudder in ((5, 10), (3, 20), (2, 40), (1, 160))
)
OFF_HEADING, OFF_RUDDER = WEIGHT_LADDER[0]
# Weights of the scaled states of a regulator: offset, heading, sway, yaw, rudder, integral [1].
WEIGHTS = np.diag([1.0, 1.0, 0.0, 0.0, 1.0, 1.0])
# Ships of drawn coefficients, and the share of them that a regulator is to hold by the linear theory [1].
DRAWN_SHIPS, HELD_SHARE = 64, 0.98
# Time in which that much rudder put over weighs as much; no faster than the gear does it.
STROKE_TIME = 0.1
# Time for which half a beam off the line weighs as much: the integral.
INTEGRAL_TIME = 1.2
# Time that a bend is looked ahead, and in which the integral is led back where the gear cannot follow.
LEAD_TIME, UNWINDING_TIME = 0.45, 0.15
# Speed over the one that a regulator was made for, below which its gains stay [1].
SLOWEST = 0.05
# Least decay of the slowest motion over the fastest that counts as stable [1]: rounding moves poles by less.
LEAST_DECAY, LEAST_DECAY_OF_PILOT = 1e-7, 1e-6

# Deceleration of a plan of speeds over that with the propeller stopped [1].
EASE = 0.5
# Time in which the speed governor makes up what is lacking.
GOVERNOR_TIME = 3.0
# Straight pieces of a change of speed: along the way the square of the speed is linear, the speed is not.
PIECES = 4
