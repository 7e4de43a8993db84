"""Numbers of the estimator that one may want to change; noises and priors are ``ProcessNoise`` and ``Prior``."""

import math

# Of the ship [m] whose times and noises stand here; those of other ships follow by Froude's law.
REFERENCE_LENGTH = 230.0

# Longest step of the motion: a quarter of the root of length over gravity, in which velocities change little.
STEPS_A_PERIOD = 4.0
# Time [s] after which an estimate without any call begins anew.
LONGEST_GAP = 600.0
# Time [s] in which what readings tell of the coefficients fades: a canal changes within half an hour.
COEFFICIENT_MEMORY = 1800.0
# Periods of a sensor without a reading after which a note says so.
SILENT_PERIODS = 5.0
# Two times [s] closer than this are one.
SAME_TIME = 1e-9

# Readings of each sensor that an estimate starts from, by their median: one may be wrong.
START_READINGS = 3
# Periods for which readings of a sensor are refused before the bank of filters is asked who is wrong.
REFUSED_PERIODS = 5.0
# Time [s, of the reference ship] that the bank of filters goes back.
REPLAY_TIME = 60.0
# Time [s, of the reference ship] between two questions to the bank.
JUDGE_WAIT = 5.0
# Age [s, of the reference ship] of the readings that a new start begins with.
RESTART_TIME = 20.0
# Readings of one and the same value after which a sensor may be stuck and the bank is asked.
STUCK_READINGS = 20
# A faulty sensor's error, a Gauss-Markov process: its standard deviation [white standard deviations], wide enough for a
# log stuck at 0, and how far it wanders [white standard deviations per root period]: a spoof by 0.5 m/s, a stuck value.
FAULT_STD, FAULT_WALK = 100.0, 0.3
# The same of a faulty rudder indicator [rad], [s, of the reference ship].
RUDDER_FAULT_STD, RUDDER_FAULT_TIME = math.radians(15.0), 60.0
# Factor on the walks of the velocities where the model is wrong: as much as a passing ship or another bank.
MODEL_FAULT = 3.0
# Share of that standard deviation at the start of a drift, and of a step that no gate refuses.
DRIFT_START, STEP_START = 0.02, 0.1
# Time [s, of the reference ship] for which a sensor is left out unless its error becomes as small as its noise.
LONGEST_FAULT = 300.0
# Log-likelihood [1] by which a hypothesis with a fault more, or a new start, has to explain the readings better.
FAULT_PRIOR = math.log(50.0)

# Normalised innovation squared [1] of a gross error. Below it, sensors of several kinds that are all refused outvote
# the model.
GROSS_ERROR_NIS = 1e4
# Readings over which the innovations of a sensor are summed to find a drift: quick and slow ones.
DRIFT_MEMORIES = (6.0, 12.0, 24.0)
# Standard deviations of such a sum that raise a suspicion: by chance once in 1.7 million independent sums.
DRIFT_THRESHOLD = 5.0
# Standard deviations at which an innovation is cut off in these sums: a larger one is the gate's matter.
DRIFT_MOST_INNOVATION = 5.0

# Distance of the sigma points from the mean [variances]: the fourth moment of a Gaussian is met.
SQUARED_DISTANCE = 3.0
# Standard deviations by which a considered coefficient is moved: so near that the difference is the derivative.
CONSIDERED_DISTANCE = 0.1

# Twins: standard deviations of the start's place [m, of the reference ship] and heading [rad].
TWIN_START_STD = (3.0, math.radians(1.0))
# Twins: time for which the rudder is put over to one side [roots of length over gravity].
TWIN_SIDE_TIME = 8.0
# Twins: time [s, of the reference ship] at the start that is left out of the statistics.
SETTLING_TIME = 60.0
# Probability of the bounds of a consistency test [1].
CONFIDENCE = 0.95
