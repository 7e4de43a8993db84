"""Settings of the simulation."""

import math

# Largest heading of the model [rad]: beyond it the ship lies across the canal.
HEADING_LIMIT = math.radians(85)
# Largest surge or sway velocity [m/s] and yaw rate [rad/s]: beyond them the motion diverges.
SPEED_LIMIT, RATE_LIMIT = 100.0, 10.0

# Tolerance of the clearance at a contact [m], and the clearance that counts as contact when the tries run out [m].
CONTACT_TOLERANCE, CONTACT_CLOSENESS = 1e-9, 1e-6
# Clearance over the width [1] at which a diverging motion counts as contact: at midship suction becomes infinite.
NEAR_THE_BANK = 1e-3
# Instants of a voyage at which the least clearance to the banks is computed: from this many to about twice as many.
CLEARANCE_ROWS = 1000

# Error of the track relative to the beam [1] above which a note warns of a long time step.
STEP_ERROR_LIMIT = 0.02
# Steps of a voyage, and voyages of an ensemble, that are repeated with half the step to find that error.
STEP_CHECK_STEPS, STEP_CHECK_VOYAGES = 16, 64

# Defaults of a voyage: Froude number by the ship's length, limited to this share of the choking speed; ship lengths,
# and steps in each; start of a map, relative to the distance from the centreline to contact [1].
DEFAULT_FROUDE, DEFAULT_SHARE_OF_CHOKING = 0.16, 0.7
DEFAULT_LENGTHS, DEFAULT_STEPS_A_LENGTH = 15.0, 200.0
DEFAULT_OFFSET = 0.78

# Share by which a model's own revolutions may differ from those that keep the approach speed of a trial: tests at the
# model's self-propulsion point run at fewer than balance its resistance (KVLCC2: 13 %).
OWN_REVOLUTIONS = 0.2

# Froude number by the ship's length [1] above which a note questions the speed: displacement hulls do not reach it.
MOST_FROUDE = 0.6

# Voyages per block: less than a second of work, so that progress bars move and Ctrl-C takes effect.
BLOCK_VESSELS = 65_536

# Most steps of a voyage, which stores each of them, and of a voyage of an ensemble, which stores only its end.
MOST_ROWS, MOST_STEPS = 5_000_000, 1_000_000_000
# Most voyages of an ensemble, some 60 bytes each; most samples of coefficients.
MOST_VOYAGES, MOST_SAMPLES = 100_000_000, 10_000_000
MOST_WORKERS = 4096  # Most threads or processes
# Most points of a hull outline, each a line of the generated program, and their largest distance from midship [m].
MOST_POINTS, MOST_EXTENT = 1000, 1e6
