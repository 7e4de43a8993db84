"""Settings of the estimator; noises and priors are in ``ProcessNoise`` and ``Prior``."""

import math

# Length of the ship [m] for the times and noises below; those of other ships follow by Froude's law.
REFERENCE_LENGTH = 230.0

# Longest step of the motion: this share of the root of length over gravity, in which velocities change little.
STEPS_A_PERIOD = 4.0
LONGEST_GAP = 600.0  # Time [s] after which an estimate without any call restarts
# Time [s] in which corrections of the coefficients fade: a canal changes within half an hour.
COEFFICIENT_MEMORY = 1800.0
SILENT_PERIODS = 5.0  # Periods of a sensor without a reading before a note
SAME_TIME = 1e-9  # Times [s] closer than this count as equal

START_READINGS = 3  # Readings per sensor for a start, combined by their median: one may be wrong
REFUSED_PERIODS = 5.0  # Periods with refused readings of a sensor before the bank of filters is run
REPLAY_TIME = 60.0  # Length of the bank's window [s, of the reference ship]
JUDGE_WAIT = 5.0  # Time [s, of the reference ship] between two runs of the bank
RESTART_TIME = 20.0  # Age [s, of the reference ship] of the readings used for a restart
STUCK_READINGS = 20  # Equal readings in a row after which a sensor may be stuck and the bank is run
# Error of a faulty sensor, a Gauss-Markov process: its standard deviation [white standard deviations], wide enough for
# a log stuck at 0, and its random walk [white standard deviations per root period], for a spoof by 0.5 m/s or a stuck
# value.
FAULT_STD, FAULT_WALK = 100.0, 0.3
# The same for a faulty rudder indicator [rad], [s, of the reference ship].
RUDDER_FAULT_STD, RUDDER_FAULT_TIME = math.radians(15.0), 60.0
# Factor on the random walks of the velocities under a model fault: the size of a passing ship or another bank.
MODEL_FAULT = 3.0
DRIFT_ONSETS = (60.0, 30.0, 15.0)  # Beginnings of a drift that the bank tries [s ago, of the reference ship]
# Share of that standard deviation at the start of a drift, and at the start of a step that no gate refuses.
DRIFT_START, STEP_START = 0.02, 0.1
# Time [s, of the reference ship] for which a sensor is left out, unless its error becomes as small as its noise.
LONGEST_FAULT = 300.0
FAULT_PRIOR = math.log(50.0)  # Least gain in log-likelihood [1] of a hypothesis with one more fault, or of a restart

# Normalised innovation squared [1] of a gross error. Below it, refused sensors of several kinds outvote the model.
GROSS_ERROR_NIS = 1e4
DRIFT_MEMORIES = (6.0, 12.0, 24.0)  # Memories [readings] of the innovation sums that find a drift: fast and slow ones
# Size of such a sum that raises a suspicion [standard deviations]: by chance once in 1.7 million independent sums.
DRIFT_THRESHOLD = 5.0
# Size of such a sum at which the bank of filters is run and decides [standard deviations]: slow errors of fixes, as
# states, take up half of a step.
BANK_THRESHOLD = 3.5
# Limit of an innovation in these sums [standard deviations]: larger ones are left to the gate.
DRIFT_MOST_INNOVATION = 5.0

# Distance of the sigma points from the mean [variances]: matches the fourth moment of a Gaussian.
SQUARED_DISTANCE = 3.0

# Twins: standard deviations of the starting position [m, of the reference ship] and heading [rad].
TWIN_START_STD = (3.0, math.radians(1.0))
TWIN_SIDE_TIME = 8.0  # Twins: time with the rudder to one side [roots of length over gravity]
SETTLING_TIME = 60.0  # Twins: time [s, of the reference ship] at the start that is left out of the statistics
CONFIDENCE = 0.95  # Probability of the bounds of a consistency test [1]
