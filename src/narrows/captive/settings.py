"""Settings of the checks of captive tests, with unit and reason."""

# Accelerations of oscillating tests
HARMONICS = 5  # Number of harmonics of a run's period
ACCELERATION_TOLERANCE = 0.01  # [1] largest difference from the motion, over the size in the table
LEAST_ACCELERATION = 0.01  # [U2/L] size of accelerations in a table in which nothing oscillates
SMALL_REST = 0.02  # [1] residual of a velocity after its harmonics in a periodic run
WHITE = 0.5  # [1] share of white residual, if it is larger
SIGNIFICANT = 9.0  # power of a harmonic relative to that of its noise
SAMPLED = 600  # rows of a run used to find its period and compare accelerations; all are replaced
# Sizes
MOST_HEAVE = 0.5  # [1] of the draft: more is no sinkage of a floating ship
MUCH_HEAVE = 0.2  # [1] of the draft: beyond it a note is given
MASS_APART = 2.0  # ratio of mass and displacement, either way, beyond which one is wrong
MASS_OFF = 1.1  # the same, beyond which a note is given
GYRATION = (0.1, 0.5)  # [1] radius of gyration over length of any ship; about 0.25 is usual
STRONGEST = 30.0  # force relative to mass times speed squared over length: more is no force on this ship
STEADY_RATE = 1e-6  # [1] of the usual rates: below it a row is steady
LEAST_LEEWAY = 0.01  # [1] least sideways speed over speed that counts as drift
# Kinematic consistency
STRETCHES = 60  # Number of stretches of a test over which changes are compared, to average noise
FEWEST_STRETCHES = 8  # fewer give no report
LEAST_CORRELATION = 0.9  # least correlation of two columns of the same motion
SLOPE_TOLERANCE = 1.25  # factor within which they agree
FAINT_SHARE = 0.1  # [1] least variation of a column relative to other tests
SHAKE = 0.003  # [1] carriage vibration as a share of a length, a radian or the speed: less carries no information
ROW_GAP = 2.5  # usual times between rows: longer gaps are not compared
# Rows
SHORTEST_RECORD = 20  # rows for the filter's transients
# [N, N, N m] standard deviation of measured forces: middle of FHR's harmonic tests
FORCE_NOISE = {"X": 0.35, "Y": 0.5, "N": 0.65}
# Missing-value markers and spikes, which are left out
MISSING_MARKS = (999.0, 999.9, 999.99, 9999.0, 9999.9, 9999.99, 99999.0, 999999.0, 32767.0, 32768.0, 1e10, 9.99e9)
MARK_APART = 3.0  # [1] distance of a marker from the other rows, in their spread
FEWEST_MARKED = 3  # rows that hold a marker exactly and more often than any other value
SPIKE = 20.0  # [1] the same for any number: a ramp or an oscillation has rows between
LONE_SHARE = 0.01  # [1] of a run's rows: largest share of spikes, one at least
USUAL_SHARE = 0.95  # [1] quantile of a column's sizes in the table that counts as usual
FEWEST_SCREENED = 8  # rows of a run compared among themselves; shorter runs are compared together
MOST_SPOILED = 0.05  # [1] of a table's rows: a column with more wrong values is refused
# Names of rows that sum others up, not tests
TOTALS = ("mean", "average", "total", "sum", "std", "min", "max", "mittelwert", "summe", "gemiddelde", "平均")
# Largest sizes that a column without a unit may have
DEEPEST = 100.0  # [1] water depth over draft
WIDEST = 200.0  # [1] width of the canal over beam
FASTEST = 0.5  # [1] Froude number by length, near which the wave resistance of a displacement hull is highest
PAST_CHOKING = 1.3  # [1] speed over that which chokes the canal by one-dimensional theory
