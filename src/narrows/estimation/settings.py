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
