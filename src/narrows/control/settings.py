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

# Numbers of the predictive helm that one may want to change.
# How far ahead a plan reaches [ship lengths], in how many intervals, at most how many, and plans made an interval.
HORIZON_LENGTHS = 2.4

INTERVALS, MOST_INTERVALS, PLANS_AN_INTERVAL = 30, 60, 5

# Rounds of sequential quadratic programming for a first plan, and iterations of each program.
FIRST_ROUNDS, MOST_ITERATIONS = 6, 500

# Share of the period by which a plan may come early: times of steps are sums [1].
EARLY = 1e-6

# Steps of Runge and Kutta's method an interval.
STEPS = 2

# Least distance between hull and bank unless a margin is given [beams].
MARGIN = 0.15

# Costs of a clearance that is short by half a beam: by the length, and by its square.
SHORT, SHORT_SQUARED = 50.0, 10.0

# Clearance beyond the margin from which a corner needs no row [half beams]: from plan to plan less is used up.
SPARE = 4.0

# Rudder turned through the usual weight within this many ship lengths ...
RUDDER_LENGTHS = 0.16

# ... weighs this share of it [1].
RUDDER_RATE_WEIGHT = 0.1

# Beyond these no plan is linearised: heading [rad], clearance [half beams], sway over speed, yaw over speed by half
# length [1].
MOST_HEADING = np.radians(25.0)

LEAST_CLEARANCE, MOST_DRIFT, MOST_TURN = 0.2, 0.5, 1.0

# Share of the rudder's limit that holding an offset may take [1]; where it takes more the helm comes nearer the middle,
# and goes back no faster than all the way in so many of the times in which the push is estimated.
RESERVE, RETURNING = 0.7, 20.0

# Ship lengths sailed in which the estimate of a force of any kind comes two thirds of the way.
PUSH_LENGTHS = 0.3

# The uncertainty of the bank's force: up to which share of the way to a bank it is taken, and at how many places.
FURTHEST, SHARES = 0.9, 61

# Steady courses: places a ship length, at most, and offsets from the one that is held to the middle, both included.
PLACES_A_LENGTH, MOST_PLACES, WAYS = 2, 4000, 9

# Change of speed from which steady courses are found anew [1].
OTHER_SPEED = 0.02

# Numbers of the closed loop.
# Frequencies at which a loop is looked at.
FREQUENCIES = 3000

# Rounds of Newton's method for the steady state of a loop, and how far off it may be, in sizes of the states [1].
NEWTON_ROUNDS, SAME_STATE = 20, 1e-9

# Ship lengths of a voyage unless a duration is given.
LOOP_DURATION = 40.0

# Voyages that look for the delay that a loop tolerates: ship lengths that each lasts, beams off the line where it
# begins, its offset late over that at the start beyond which it is lost [1], the longest delay [ship lengths], and how
# close the answer is [1].
LOOP_TIME, LOOP_OFFSET, LOST_LOOP, MOST_DELAY, DELAY_DIGITS = 120.0, 0.03, 1.0, 2.0, 0.02
