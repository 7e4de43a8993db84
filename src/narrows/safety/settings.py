"""Settings of the safe envelope, each with unit and reason."""

# The question
RESERVE = 1 / 3  # [1] of the rudder, left on the steady course
KEEL_SHARE = 0.05  # [1] of the draft, left under the keel
OFFSETS = 25  # default number of places over the width
SPEEDS = 15  # default number of speeds
ALONG_OFFSETS, ALONG_SPEEDS = 9, 9  # the same at each of the places along a waterway
SAME_ROOM = 1e-3  # [1] sections whose room differs by less are alike: maps are rounded
SLOWEST = 0.3  # [1] of the choking speed: default of the lowest speed
FASTEST = 1.05  # [1] of the choking speed: default of the highest speed
# Trials
TRIAL_LENGTHS = 15.0  # [ship lengths] duration of a trial after a gust
BACK_LENGTHS = 3.0  # [ship lengths] last part, in which the ship must be back
STEPS_A_LENGTH = 40  # steps of a trial per ship length
TRIAL_BLOCK = 65_536  # trials per call
MOST_TRIALS = 50_000_000  # limit of one call: beyond it the result does not fit in memory
LIKELY_SAMPLES = 200  # disturbances of the best-estimate trials
TUNING_SAMPLES = 200  # samples of the trials that choose a pilot's tuning
TUNING_OFFSETS = 5  # offsets of these trials
TUNING_SPEEDS = 2  # speeds of these trials
TUNING_SEED = 13  # added to the seed, so that choosing and judging use different samples
SAMPLES = 800  # default: the 95 % interval of a share of 95 % is then 93 to 96 %
# The result
SURE_SHARE = 0.95  # [1] of the cases that must be controllable for a safe place
SHIP_LENGTH = 30.0  # [m] a shorter hull counts as a model
