"""Numbers of the simulation that one may want to change."""

import math

# Heading [rad] beyond which a ship lies across the canal and the model does not hold.
HEADING_LIMIT = math.radians(85)
# Surge or sway velocity [m/s] and yaw rate [rad/s] that no ship has: the motion diverges.
SPEED_LIMIT, RATE_LIMIT = 100.0, 10.0

# How near to contact the end of a voyage is placed [m], and the clearance [m] that counts as closed afterwards.
CONTACT_TOLERANCE, CONTACT_CLOSENESS = 1e-9, 1e-6
# Clearance over the width [1] at which a motion that diverges has met the bank: at midship the suction ends infinite.
NEAR_THE_BANK = 1e-3

# Error of the track over the beam [1] above which a note says that the time step is too long.
STEP_ERROR_LIMIT = 0.02
# Steps of a voyage, and voyages of an ensemble, that are taken again with half the step to find that error.
STEP_CHECK_STEPS, STEP_CHECK_VOYAGES = 16, 64

# Defaults of a voyage: Froude number by the ship's length, below this share of the speed that chokes the canal; ship
# lengths sailed, with so many steps in each; start of a map, over the way from the centreline to contact [1].
DEFAULT_FROUDE, DEFAULT_SHARE_OF_CHOKING = 0.16, 0.7
DEFAULT_LENGTHS, DEFAULT_STEPS_A_LENGTH = 15.0, 200.0
DEFAULT_OFFSET = 0.78

# Voyages at a time: a fraction of a second's work, so that bars move and Ctrl-C is heard.
BLOCK_VESSELS = 65_536
# Voyages of a stored task, at least: enough that writing and scheduling do not count.
TASK_VESSELS = 100_000

# Most steps of a voyage, which keeps each of them, and of a voyage of an ensemble, which keeps only its end.
MOST_ROWS, MOST_STEPS = 5_000_000, 1_000_000_000
# Most voyages of an ensemble, some 60 bytes each, in memory and in a store; and most samples of coefficients.
MOST_IN_MEMORY, MOST_STORED, MOST_SAMPLES = 100_000_000, 100_000_000_000, 10_000_000
MOST_WORKERS = 4096
# Points of an outline, which is a part of the program, and how far they may lie from midship [m].
MOST_POINTS, MOST_EXTENT = 1000, 1e6
