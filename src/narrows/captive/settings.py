"""Numbers of the checks of captive tests: unit and reason of each."""

# Accelerations of oscillating tests
HARMONICS = 5  # of a run's period
ACCELERATION_TOLERANCE = 0.01  # [1] of an acceleration's size in the table: farther from the motion, it is replaced
LEAST_ACCELERATION = 0.01  # [U2/L] size of accelerations in a table in which nothing oscillates
SMALL_REST = 0.02  # [1] of a velocity that the harmonics leave in a periodic run
WHITE = 0.5  # [1] share without memory from row to row, where they leave more
SIGNIFICANT = 9.0  # power of a harmonic over that of its noise
SAMPLED = 600  # rows of a run by which its period is found and accelerations are compared; all are replaced
# Sizes
MOST_HEAVE = 0.5  # [1] of the draft: more is no sinkage of a ship afloat
MUCH_HEAVE = 0.2  # [1] of the draft: so much is reported
MASS_APART = 2.0  # mass over displacement, or the other way, beyond which one is wrong
MASS_OFF = 1.1  # the same, beyond which it is reported
GYRATION = (0.1, 0.5)  # [1] radius of gyration over length of any ship; about 0.25 is usual
STRONGEST = 30.0  # force over what throws the ship's mass across its length at its speed: no force on this ship
STEADY_RATE = 1e-6  # [1] of the usual rates: a row below is steady
LEAST_LEEWAY = 0.01  # [1] sideways speed over speed that counts as drift
# Kinematic consistency
STRETCHES = 60  # of a test over which changes are compared, which takes out noise
FEWEST_STRETCHES = 8  # with fewer nothing is reported
FEWEST_RATES = 2  # columns that must give the time from row to row where no column does
LEAST_CORRELATION = 0.9  # two columns are of one motion beyond this correlation
SLOPE_TOLERANCE = 1.25  # and agree within this factor
FAINT_SHARE = 0.1  # [1] a test in which a column varies by less than this part of others is not used
SHAKE = 0.003  # [1] part of a length, a radian or the speed by which a carriage shakes: less tells nothing
ROW_GAP = 2.5  # usual times from row to row: over more nothing is compared, as rows were left out
# Rows
SHORTEST_RECORD = 20  # rows that the filter needs to run in and out
# [N, N, N m] standard deviation of measured forces: middle of FHR's harmonic tests
FORCE_NOISE = {"X": 0.35, "Y": 0.5, "N": 0.65}
# Marks of missing values and spikes, which are left out
MISSING_MARKS = (999.0, 999.9, 999.99, 9999.0, 9999.9, 9999.99, 99999.0, 999999.0, 32767.0, 32768.0, 1e10, 9.99e9)
MARK_APART = 3.0  # [1] times the spread of the other rows by which such a number is no measurement
SPIKE = 20.0  # [1] the same for any number: a ramp or an oscillation has rows between
LONE_SHARE = 0.01  # [1] of a run's rows that spikes may be, one at least
USUAL_SHARE = 0.95  # [1] of a column's sizes in the table that are below the one which is usual
FEWEST_SCREENED = 8  # rows of a run that are compared among themselves; shorter runs are compared together
MOST_SPOILED = 0.05  # [1] of a table's rows: where more of a column are wrong it is refused
