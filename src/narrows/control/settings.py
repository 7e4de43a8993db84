"""Settings of the helms; the unit of time is that of a ship length, the unit of rates its inverse."""

import numpy as np

# Time of looking ahead for bends.
LEAD_TIME = 0.45
# Lowest speed relative to a regulator's design speed, below which its gains stay constant [1].
SLOWEST = 0.05
# Least decay rate of the slowest motion over the fastest that counts as stable [1]: rounding moves poles by less.
LEAST_DECAY = 1e-7
# Predictive helm: horizon of a plan [ship lengths], number of intervals, its largest number, and plans per interval.
HORIZON_LENGTHS = 2.4
INTERVALS, MOST_INTERVALS, PLANS_AN_INTERVAL = 30, 60, 5
# Rounds of sequential quadratic programming for a first plan, and iterations of each program.
FIRST_ROUNDS, MOST_ITERATIONS = 6, 500
# Tolerance for an early plan, relative to the period [1]: times are sums with rounding errors.
TIME_TOLERANCE = 1e-6
# Runge-Kutta steps per interval.
STEPS = 2
# Default of the least distance between hull and bank [beams].
MARGIN = 0.15
# Cost of half a beam of missing clearance, and its second derivative.
SHORT, SHORT_SQUARED = 50.0, 10.0
# Clearance beyond the margin above which a corner needs no constraint [half beams]: less is used up between plans.
FREE_CLEARANCE = 4.0
# Limits of linearising a plan: heading [rad], clearance [half beams]; sway, and yaw by half length, over speed [1].
MOST_HEADING = np.radians(25.0)
LEAST_CLEARANCE, MOST_DRIFT, MOST_TURN = 0.2, 0.5, 1.0
# Share of the rudder's limit that holding an offset may take [1]: beyond it the helm moves towards the middle. It takes
# at least this many time constants of the force estimate for the whole way back.
RESERVE, RETURNING = 0.7, 20.0
# Distance in which the estimate of an external force comes two thirds of the way [ship lengths].
PUSH_LENGTHS = 0.3
# Steady courses: places per ship length, largest number, and offsets from the requested one to the middle.
PLACES_A_LENGTH, MOST_PLACES, WAYS = 2, 4000, 9
# Relative change of speed that triggers new steady courses [1].
OTHER_SPEED = 0.02
# Closed loop: number of frequencies of its margins.
FREQUENCIES = 3000
# Largest number of Newton rounds for a loop's steady state, and its tolerance relative to the scales of the states [1].
NEWTON_ROUNDS, SAME_STATE = 20, 1e-9
# Default duration of a voyage [ship lengths].
LOOP_DURATION = 40.0
