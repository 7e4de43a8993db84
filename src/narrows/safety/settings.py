"""Settings of the safe envelope, each with unit and reason."""

# The question
RESERVE = 1 / 3  # [1] of the rudder, left when the ship is steady
KEEL_SHARE = 0.05  # [1] of the draft, left under the keel
OFFSETS = 25  # places over the width where none are given
SPEEDS = 15  # speeds where none are given
SLOWEST = 0.3  # [1] of the speed that chokes the canal: lowest speed where none is given
FASTEST = 1.05  # [1] of the speed that chokes the canal: highest speed where none is given
# Trials
TRIAL_LENGTHS = 15.0  # [ship lengths] a trial lasts after a gust
BACK_LENGTHS = 3.0  # [ship lengths] the last of them, through which the ship is to be back
STEPS_A_LENGTH = 40  # steps of a trial on the way of a ship length
TRIAL_BLOCK = 65_536  # trials that are sailed in one call
MOST_TRIALS = 50_000_000  # points of one call: beyond it the answer does not fit in memory
LIKELY_SAMPLES = 200  # disturbances in which the best estimate is tried
TUNING_SAMPLES = 200  # of the trials that choose a pilot's tuning
TUNING_OFFSETS = 5  # places of these trials
TUNING_SPEEDS = 2  # speeds of these trials
TUNING_SEED = 13  # added to the seed: samples that choose are not those that judge
FIRST_SAMPLES = 400  # where no number is given; doubled until the edge is settled
MOST_SAMPLES = 6400  # up to so many
# The result
SURE_SHARE = 0.95  # [1] of the cases: a place where so many are controllable is safe
SAME_ANGLE = 1e-6  # [rad] rudder angles closer than this are one
LEAST_ANGLE = 1e-4  # [rad] the least rudder angle that is reported
SHIP_LENGTH = 30.0  # [m] a shorter hull is taken for a model's
