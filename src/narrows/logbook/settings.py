"""Numbers of logs, their checks and what is learned from them: unit and reason of each."""

import numpy as np

# Reading
MOST_ROWS = 500_000  # rows of a record; a longer one goes on in another, so that memory does not grow with the log
RECORD_GAP = 300.0  # [s] without a row, after which another record begins
PIECE_ROWS = 32_000  # rows that are held at once
HEADING_GAP = 10.0  # [s] between two headings that are still joined
# Checks
MOST_CHECKED = 20  # records that are fitted to be checked: faults of sensors are in all of them
MOST_REREAD = 3  # records by which signs, units and axes are compared
CHECKED_SPREAD = 0.1  # [1] of each coefficient, where the model has no covariance
FALSE_ALARM = 0.05  # probability of a finding in a log without a fault, by the bound of Bonferroni
HARMFUL_SHIFT = 0.5  # [standard errors of a coefficient] a fault that must be mended: coverage falls from 95 to 92 %
MOST_HARMLESS = 10  # faults that move no coefficient, estimated before the search for one that does ends
OUTLYING = 0.05  # [1] of the readings of a signal: with more outliers it is read wrongly still
FEWEST_RUNS = 10  # of equal values that may be repeats
REGULAR = 0.8  # [1] of the runs of equal values that are of one length where values are repeated
REPEATED_LENGTHS = 0.04  # [ship lengths] over which a value is repeated, a step of the filter: shorter ones do no harm
GAP_STEPS = 10.0  # usual steps of a signal; a longer step is a gap
GAP_LENGTHS = 0.25  # ship lengths of way; a shorter gap does not matter
ASHORE = 0.002  # [1] of the times a hull may reach into a bank by the noise of its position
MOST_FROUDE = 0.5  # [1] of displacement ships
CHECK_STEPS = 12  # of the search before faults are tested
STUCK_LENGTHS = 0.3  # [ship lengths] for which a stuck sensor shows the same value
MOVED = 10.0  # standard deviations of the noise that the ship moves in that time by all other signals
STUCK_READINGS = 8  # equal values of a sensor that may be stuck
SELDOM = 0.2  # [ship lengths] between values of a rudder: a helmsman moves it more often
STILL = np.radians(0.2)  # [rad] a rudder that moves less never moves
LEAST_TURN = np.radians(2.0)  # [rad] a change of heading that is a swing
SWINGS = 2  # turns to either side that a rudder at rest does not explain
RUDDER_REST = 3.0  # [ship lengths] a helmsman may leave the rudder alone
RUDDER_REST_BETWEEN_BANKS = 10.0  # [ship lengths] the same between banks
# What a record taught
LEARNED_TO = 0.5  # [1] of the standard error left: the record has three quarters of the information
SHARPENED_TO = 0.9  # [1] of the standard error left: the record has a fifth of the information
TIED_CORRELATION = 1 - 1e-9  # [1] two coefficients beyond it are tied
PAIR_CORRELATION = 0.7  # [1] two coefficients beyond it are reported as a pair
CHANGE_SAMPLES = 200  # coefficients and disturbances: a look, not a chart to sail by
CHANGE_OFFSETS = (0.0, 0.5, 1.0, 1.5)  # [1] offsets over the farthest of a record
CHANGE_SPEEDS = (0.8, 1.0, 1.2)  # [1] speeds over the mean of a record
RUDDER_BAND = (0.05, 0.95)  # [1] shares of the samples between which a rudder angle is given
WINDAGE = 0.1  # [1] lateral area over length squared, of a loaded container ship about
WIND_LEVER = 0.1  # [1] where the wind's force acts, over the length
# Steady legs
PLAN_SAMPLES = 400  # coefficients that must leave the rudder its reserve
MOST_LEGS = 1000  # of a plan
MOST_PLAN_SAMPLES = 100_000  # of a plan
SLOWEST_LEG = 0.35  # [1] of the speed that chokes the canal, where no speeds are given
FASTEST_LEG = 0.7  # [1] of the speed that chokes the canal, where no speeds are given
LEG_SPEEDS = 3  # how many speeds between these
OFFSET_STEPS = 20  # offsets to either side, about
CONTRADICTION = 0.01  # probability of as large a chi-square below which legs contradict the model or each other
WRONG_SIGN_GAIN = 2 * np.log(100)  # [1] of chi-square: with the right sign the wrong one gains so much in 1 % of cases
# [ship lengths] to come to a steady course before a leg is read: on twins under a regulator in gusts the ship still
# turns back to its line after 4, and the interval of b_bank holds the truth in 76 %; after 8 in 92 %, after 12 in 92 %
SETTLING = 8.0
MOST_ANGLE = 1.2  # [rad] of a rudder, a drift or a heading that can be meant
MISPLACED = 1 / 30  # [beams] banks are from where they are thought to be, where nothing is given
UPDATE_ROUNDS = 50  # linearisations at most
UPDATE_SETTLED = 1e-6  # [standard deviations] that the last round may still move anything
# Transits that are planned or simulated
ROUTINE = 2400.0  # [s] of a transit where no waterway gives its time
LONGEST_TRANSIT = 3600.0  # [s] of a transit that a waterway gives
MOST_TIME = 86_400.0  # [s] that may be asked for
SIMULATED_TRANSITS = 7  # of each kind: standard errors are the median over their gusts and wander
EXCURSION_SHARES = (0.5, 1.0)  # [1] of the safe offset
EXCURSION_STAY = 5.0  # [ship lengths] that an excursion stays aside
EXCURSION_TURN = 0.6  # [ship lengths] to get there
ENVELOPE_SAMPLES = 200  # of the quick safe envelope
AIM_LENGTHS = 0.2  # [ship lengths] of one piece of an aim, at most
GUST_PIECES = 5  # pieces of a schedule of gusts, in the time that a gust stays
TRANSIT_STEPS = 80  # of the voyage on the way of a ship length, at least
PILOT_COURSES = 21  # offsets at which a pilot knows the steady course, straight between them
ORDER_INTERVAL = 4.0  # [s] from one helm order to the next, at most
ORDERS_A_LENGTH = 20  # helm orders on the way of a ship length, at least: those of a small model follow faster
PUSH_STEP = 1.0  # [s] of forces that change, and of the voyage, at most
AIM_STEP = 10.0  # [s] of one piece of an aim, at most
CURRENT = 0.3  # [m/s] standard deviation of the current along the canal
MOST_DRAWS = 200  # of coefficients, until one is within the bounds
MOST_SHIPS = 100  # that may be drawn until one comes through
