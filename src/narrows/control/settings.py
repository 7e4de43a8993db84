"""Settings of the helms; times in times of a ship length, rates in its inverse."""

import math

import numpy as np

# Bryson's rule for the track pilot and the plans: heading and rudder off the course [rad] that weigh as much as half a
# beam off the line.
OFF_HEADING, OFF_RUDDER = math.radians(5.0), math.radians(10.0)

# Time that a bend is looked ahead.
LEAD_TIME = 0.45

# Speed over the one that a regulator was made for, below which its gains stay [1].
SLOWEST = 0.05

# Least decay of the slowest motion over the fastest that counts as stable [1]: rounding moves poles by less.
LEAST_DECAY = 1e-7

# Deceleration of a plan of speeds over that with the propeller stopped [1].
EASE = 0.5

# Most revolutions of an engine that nothing is said of, over those that keep the fastest limit [1].
ENGINE_RESERVE = 1.5

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

# Numbers of flights that design a regulator.
# Ship lengths of a flight, the last of them through which the ship is to be on its line, and steps a ship length.
FLIGHT_LENGTHS, LATE_LENGTHS, FLIGHT_STEPS = 11.7, 1.2, 50

# Standard deviations of what the regulator sees: the offset in beams [1]; the heading [rad], and as much of the speed
# for the sway velocity and of a turn a ship length for the yaw rate.
FLIGHT_NOISE = 0.01, np.radians(0.1)

# Standard deviation of the heading at the start [rad].
FLIGHT_HEADING = np.radians(1.0)

# What a design costs beside the share of lost ships: a late offset of half a beam, and a travel of the rudder of so
# much a ship length [rad], as shares of a lost ship [1].
OFF_SHARE, TRAVEL_SHARE, FULL_TRAVEL = 0.3, 0.1, np.radians(10.0)

# First step of the search, of logarithms [1]; ships that judge over those that tune.
DESIGN_STEP, DESIGN_JUDGES = 0.3, 10
