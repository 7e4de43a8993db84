"""Numbers of logs, their checks and what is learned from them: unit and reason of each."""

import numpy as np

# Reading
MOST_ROWS = 500_000  # rows of a record; a longer one goes on in another, so that memory does not grow with the log
RECORD_GAP = 300.0  # [s] without a row, after which another record begins
PIECE_ROWS = 32_000  # rows that are held at once
HEADING_GAP = 10.0  # [s] between two headings that are still joined
# Checks: changes over windows
FEWEST_WINDOWS = 8  # windows that a factor needs
SURE = 4.0  # standard errors that a number must be away from what is right
OVERLAP = 2.0  # windows that share what they cover
STEPS_A_LENGTH = 40  # even times on the way of a ship length
FEWEST_READINGS = 16  # even times of a record, at least
MOST_READINGS = 20_000  # even times of a record, at most
SPEED_PIECES = 50  # pieces of a record whose median is its usual speed
JOINED = 3.0  # steps of a signal or of even time, over which values are still joined
# Checks: clock and place
GAP_STEPS = 10.0  # usual steps of a signal; a longer step is a gap
CLOCK_JUMP_STEPS = 2.5  # usual steps; over a longer one the clock may have jumped
GAP_LENGTHS = 0.25  # ship lengths of way; a shorter gap does not matter
CLOCK_JUMP_LENGTHS = 0.05  # ship lengths of way; a shorter jump of the clock does not matter
LITTLE_WAY = 0.5  # [1] of the way of a gap at the usual speed: with less the clock jumped, not the ship
SPEED_POSITIONS = 5  # positions before and after a gap, by which the speed there is known
ASHORE = 0.002  # [1] of the times a hull may reach into a bank by the noise of its position
# Checks: sizes that no ship has
RUDDER_EXCESS = 1.3  # [1] over the gear's limit
ADVANCE_RATIOS = (0.08, 5.0)  # [1] J = U / (n D) of a ship under way
DIAMETER = 0.65  # [1] of a propeller over the draft, where the model does not state it
MOST_TURN = 3.0  # [rad] on the way of a ship length
MOST_FROUDE = 0.5  # [1] of displacement ships
# Checks: heading
MOST_YAW_RATE = 2.0  # [rad] a ship length; no ship turns faster from one heading to the next
NOISE_FACTOR = 8.0  # standard deviations of a sensor's noise that no step reaches
COMPASS_STEP = np.radians(3.0)  # [rad] a step that a quiet compass may show, or fail to show
HEADING_WINDOWS = (0.25, 0.5, 1.0, 2.0)  # [ship lengths] windows: the one that tells most is taken
RATE_SLACK = 1.25  # factor by which a yaw rate may be off the heading's change
TRACK_SLACK = 2.0  # factor by which the track's turn, which drifts, may be off the heading's
CLEAR_OF_NOISE = 5.0  # times the compass's noise: such a change of heading must show in a yaw rate
LEAST_SHOWN = 0.5  # [1] of such a change that a yaw rate shows at least
# Checks: rudder and antenna beside the model
RUDDER_WINDOWS = (0.5, 1.0)  # [ship lengths] windows over which the rudder's effect is sought
ANTENNA_TOLERANCE = 0.2  # [ship lengths] a model's drift in turns may put the antenna wrong by this
LEAST_EFFECT = 0.25  # times the model's rudder effect; beyond minus this its sign is wrong
MOST_EFFECT = 5.0  # times the model's rudder effect; beyond this its unit is wrong
SWAY_ROUNDS = 6  # steps of Newton's method for the steady sway velocity
SWAY_STEP = 0.3  # [1] of the speed: largest of these steps
SWAY_DIFFERENCE = 0.02  # [1] of the speed: difference for the slope of the sway force
# Checks: single sensors
STUCK_STEPS = 8  # equal values of a sensor that may be stuck
STUCK_LENGTHS = 0.3  # [ship lengths] for which it shows the same value
LEAST_MOVE = 0.2  # [ship lengths] a way that any position shows
SELDOM = 0.2  # [ship lengths] between values of a rudder: a helmsman moves it more often
STILL = np.radians(0.2)  # [rad] a rudder that moves less never moves
LEAST_TURN = np.radians(2.0)  # [rad] a change of heading over a ship length that is a turn
SWINGS = 2  # turns to either side that a rudder at rest does not explain
RUDDER_REST = 3.0  # [ship lengths] a helmsman may leave the rudder alone
RUDDER_REST_BETWEEN_BANKS = 10.0  # [ship lengths] the same between banks
WIND_SHARE = 0.5  # [1] of the ship's velocity that a wind over ground must not hold
WIND_STEADIER = 3.0  # factor by which a wind from the bow must be steadier than one on the map
# Checks: velocities
VELOCITY_WINDOW = 1.0  # [ship lengths]
READING_BETTER = 3.0  # factor by which another reading of the velocities must leave less over
READING_ALIKE = 1.2  # factor by which two readings leave as much over
UNEXPLAINED = 0.015  # [1] of the way that must be left over before another reading is looked for
DISAGREEMENT = 0.3  # [1] of the way: more left over means that nothing agrees
SPEED_SLACK = 1.15  # factor by which a speed over ground may be off
MOST_CURRENT = 0.6  # [1] of the ship's speed: more is another unit
MISALIGNED = np.radians(5.0)  # [rad] a compass or an antenna that is not aligned
WRONG_TURN = np.radians(20.0)  # [rad] more than any misalignment
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
