"""Settings of logs, of their checks and of learning, each with unit and reason."""

import numpy as np

# Reading
MOST_ROWS = 500_000  # Rows of a record; a longer one continues in another, so that memory does not grow with the log
RECORD_GAP = 300.0  # Time without a row after which another record begins [s]
PIECE_ROWS = 32_000  # Rows read at once
HEADING_GAP = 10.0  # Longest time between two headings that are joined [s]
# Checks
MOST_CHECKED = 20  # Records fitted by the checks: all have the faults of the sensors
MOST_REREAD = 3  # Records by which signs, units and axes are compared
CHECKED_SPREAD = 0.1  # Standard deviation of each coefficient over its value, for a model without a covariance [1]
FALSE_ALARM = 0.05  # Probability of a finding in a log without a fault (Bonferroni) [1]
HARMFUL_SHIFT = 0.5  # Shift [standard errors of a coefficient] that must be mended: coverage falls from 95 to 92 %
MOST_HARMLESS = 10  # Harmless faults estimated before the search for a harmful one ends
OUTLYING = 0.05  # Largest share of outliers in a signal; with more, its interpretation is wrong [1]
FEWEST_RUNS = 10  # Fewest sequences of equal values that count as repeats
REGULAR = 0.8  # Least share of such sequences with one common length [1]
REPEATED_LENGTHS = 0.04  # Shortest harmful repeat: a step of the filter [ship lengths]
ASHORE = 0.002  # Share of the times at which noise of the position may put a hull in a bank [1]
MOST_FROUDE = 0.5  # Largest Froude number of displacement ships [1]
CHECK_STEPS = 12  # Steps of the search before faults are tested
STUCK_LENGTHS = 0.3  # Distance with one equal value of a stuck sensor [ship lengths]
MOVED = 10.0  # Motion by all other signals in that distance [standard deviations of the noise]
STUCK_READINGS = 8  # Fewest equal values of a stuck sensor
SELDOM = 0.2  # Longest distance between two values of a rudder: a helmsman moves it more often [ship lengths]
STILL = np.radians(0.2)  # Range of a rudder that never moves [rad]
LEAST_TURN = np.radians(2.0)  # Least change of heading that counts as a swing [rad]
SWINGS = 2  # Swings to either side that a fixed rudder does not explain
RUDDER_REST = 3.0  # Longest distance with a fixed rudder under a helmsman [ship lengths]
RUDDER_REST_BETWEEN_BANKS = 10.0  # The same between banks [ship lengths]
# Information of a record
LEARNED_TO = 0.5  # Largest remaining share of the standard error: the record has three quarters of the information [1]
SHARPENED_TO = 0.9  # Largest remaining share of the standard error: the record has a fifth of the information [1]
WINDAGE = 0.1  # Lateral area over length squared of a loaded container ship [1]
WIND_LEVER = 0.1  # Lever of the wind's force over the length [1]
# Steady legs
PLAN_SAMPLES = 400  # Samples of coefficients for which the reserve of rudder is checked
MOST_LEGS = 1000  # Most legs of a plan
SLOWEST_LEG = 0.35  # Slowest default speed over the speed that chokes the canal [1]
FASTEST_LEG = 0.7  # Fastest default speed over the speed that chokes the canal [1]
LEG_SPEEDS = 3  # Number of default speeds
OFFSET_STEPS = 20  # Approximate number of offsets to either side
CONTRADICTION = 0.01  # Probability of the chi-square below which legs contradict the model or each other [1]
WRONG_SIGN_GAIN = 2 * np.log(100)  # Drop of chi-square by the other sign; the right sign exceeds it in 1 % of cases [1]
# Distance to reach a steady course before a leg is read [ship lengths]. On twins under a regulator in gusts the
# interval of b_bank contains the truth in 76 % after 4 lengths (the ship still returns to its line), in 92 % after 8.
SETTLING = 8.0
MOST_ANGLE = 1.2  # Largest plausible rudder, drift or heading [rad]
MISPLACED = 1 / 30  # Default standard deviation of the place of a bank [beams]
UPDATE_ROUNDS = 50  # Most linearisations
UPDATE_SETTLED = 1e-6  # Largest change of the last round [standard deviations]
# Planned and simulated transits
ROUTINE = 2400.0  # Duration of a transit without a waterway [s]
LONGEST_TRANSIT = 3600.0  # Longest duration of a transit of a waterway [s]
MOST_TIME = 86_400.0  # Longest duration that a user may request [s]
SIMULATED_TRANSITS = 7  # Transits: standard errors are the median over their gusts and wander
AIM_LENGTHS = 0.2  # Longest piece of an aim [ship lengths]
GUST_PIECES = 5  # Pieces of a schedule of gusts in the correlation time of a gust
TRANSIT_STEPS = 80  # Fewest time steps in a ship length
PILOT_COURSES = 21  # Offsets of the pilot's table of steady courses, which is linear in between
ORDER_INTERVAL = 4.0  # Longest time between two helm orders [s]
ORDERS_A_LENGTH = 20  # Fewest helm orders in a ship length: a small model needs more in a second
PUSH_STEP = 1.0  # Longest step of varying forces and of the voyage [s]
AIM_STEP = 10.0  # Longest piece of an aim [s]
