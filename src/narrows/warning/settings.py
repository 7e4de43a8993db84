"""Numbers of the monitor that one may want to change: unit and reason of each."""

import math

# Alerts. Times of IEC 62923-1:2018 where it has one.
# [s] to act, below which each level begins: about 2, 7 and 10 false alerts in 100 h (decisions/warning_scores.py)
LEVELS = {"alarm": 30.0, "warning": 60.0, "caution": 90.0}
SILENCE = 30.0  # [s] a silenced alert sounds again after this time (IEC 62923-1)
REPEAT_AFTER = 60.0  # [s] an alert that nobody acknowledges sounds anew after this time
MOST_REPEATS = 9  # repeats that are counted: the field of ALF has one digit
HOLD_TIME = 10.0  # [s] a refused or drifting sensor and another depth are shown this long
HYSTERESIS = 0.7  # [1] a level ends where the time to act is longer than its threshold over this share
RAISE_DELAY = 2.0  # [s] a shorter time to act than a threshold for this long raises the level
LOWER_DELAY = 10.0  # [s] a longer time to act for this long lowers the level
DISK_TIMEOUT = 0.5  # [s] an alert waits this long for the disk, and is then published unlogged
DISK_RETRY = 1.0  # [s] a disk that failed is tried again after this time
HEARTBEAT = 60.0  # [s] between heartbeats, as the sentence HBT states it
LIST_INTERVAL = 30.0  # [s] between lists of alerts (ALC)
# Forecasts
MEMBERS, ESCAPING_MEMBERS = 1000, 128  # samples of the estimate: if nobody acts, and for each escape
HORIZON = 120.0  # [s] that is forecast
ESCAPE_TIME = 100.0  # [s] in which an escape must stay clear
TAKEOVERS = (0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 90.0, 120.0)  # [s] of escapes of the samples
LIKELY_TAKEOVERS = (*(2.0 * k for k in range(31)), *(10.0 * k for k in range(7, 13)))  # [s] of the likely ship
WRONG_ORDER_TAKEOVERS = tuple(5.0 * k for k in range(13))  # [s] of escapes after a wrong order
WRONG_ORDER_TIME = 40.0  # [s] "clear" where a wrong order leaves this long: 20 s to see it, 20 s to react
STEPS_A_PERIOD = 2.0  # steps in the root of length over gravity
ESCAPE_HEADING_GAIN = 3.0  # [1] rudder for a heading off: hard over from 12 degrees on
ESCAPE_ANGLE = 0.05  # [rad] at which the ship is steered back to its line
ESCAPE_TURN_GAIN = 3.0  # [lengths over speed] rudder for a yaw rate off: checks a swing before the course is reached
REACH_LENGTHS = 3.0  # [ship lengths] ahead, at which guidance by line of sight meets its line
ENGINE_KICK = 1.5  # [1] revolutions of a kick ahead over those of now
FAILING_SHARE = 0.05  # [1] of the samples: the last chance of the 95 % ship is where more of them meet a bank
CLEAR_SHARE = 0.01  # [1] of the samples: "clear" where no more meet a bank with the rudder as it is
RETURN_TIME = 60.0  # [s] mean time until somebody who let go of the helm takes it again without a warning
# The helmsman
HELM_DELAYS = (0, 4, 8, 12)  # [s] of reaction of the rudder; the most likely one is taken
HELM_GAINS = (0.0, 0.5, 1.5, 1.0)  # before anything is learned: trim [rad], offset over length, heading, turn [1]
HELM_GAINS_SIGMA = (0.1, 0.5, 1.0, 1.0)  # standard deviations of these
HELM_MEMORY = 300.0  # [s] of what is learned
ORDER_INTERVAL = 10.0  # [s] for which a hand leaves the rudder still, usually
RUDDER_MOVES = 0.02  # [rad] a smaller change is noise of an indicator
UNATTENDED_MOVES = 0.02  # [1/s] a rudder that nobody holds moves as often: somebody comes back, or it is noise
UNATTENDED_SCATTER = 0.2  # [rad] of a rudder that nobody holds, about what a helmsman would order
DEVIATION_TIME = 4.0  # [s] for which a deviation from the law is one piece of evidence: then the chances are calibrated
UNATTENDED_BOUNDS = 1e-4, 0.999  # [1] of the chance that nobody is at the helm
HELM_FREEDOM = 3.0  # [1] degrees of freedom of Student's t: large deviations from a law are not rare
LEAST_HELM_SCATTER = 0.035  # [rad] of a rudder about the law of its helmsman
LEAST_HELM_LIMIT = 0.17  # [rad] angles that every helmsman uses
ATTENDED_SHARE = 0.1  # [1] of a threshold [s] that holds where somebody acts in time for certain
LAPSE_INTERVAL = 3600.0  # [s] mean time between two lapses at the helm
CONTACT_TOLERANCE = 0.02  # [beams] a contact is located this closely
# Inputs
WATERWAY_REACH = 1000.0  # [m] a position farther beyond the banks or the ends is none of this waterway
SOURCE_SILENCE = 5.0  # [s] another source is used after this long without a word
PERIOD = 1.0  # [s] between updates
READ_TIMEOUT = 0.5  # [s] a read waits this long, then looks whether to stop
OPEN_TIMEOUT = 5.0  # [s] opening a connection
FIRST_PAUSE = 0.5  # [s] before a connection is tried again; each time twice as long
LONGEST_PAUSE = 30.0  # [s] between two tries at most
MOST_LINES = 20_000  # lines that wait; of more the oldest are lost
LONGEST_LINE = 4096  # [bytes] a sentence has 82, and some more before it
LATE = 60.0  # [s] a line may stand this much too late in a recording
LONGEST_SILENCE = 120.0  # [s] replayed second by second; a longer silence is skipped
# The monitor
GYRO_NOISE, TURN_NOISE = math.radians(0.2), math.radians(0.03)  # [rad], [rad/s] of instruments that nobody described
GROUND_LOG_NOISE = 0.4  # [m/s] of a speed over ground taken for that through water: a current lies between
GRACE = 20.0  # [s] after the start, in which a missing forecast is no alert
DEPTH_TOLERANCE = 0.1  # [1] of the depth: echo sounder and waterway may differ by this
SENSOR_SILENCE = 3.0  # [s] a needed sensor that is silent this long is a caution
BLIND_AFTER = 10.0  # [s] a needed sensor that is silent this long ends the forecasts
OTHER_SENSOR_SILENCE = 10.0  # [s] the same of a sensor that is not needed: a caution
NEAR_MISS = 20.0  # [m] less water beside the hull is a near miss, and never "clear"
CONTACT_CLEARANCE = 5.0  # [m] counts as contact, as in scores: positions are no more accurate
MOST_SECONDS = 86_400  # [s] of a watch that are kept: a day; the log of alerts has the rest
MOST_ALERTS = 10_000  # changes of alerts that are kept of a watch
# The page
FAREWELL = 0.3  # [s] for the last message to arrive
HEADER_TIMEOUT = 5.0  # [s] in which a browser has asked for something
MOST_CONNECTIONS = 128  # open connections of browsers; more are closed at once
LARGEST_MESSAGE = 4096  # [bytes] of what a browser sends
PING_INTERVAL = 5.0  # [s] between looks whether a browser is still there
SERVER_TIMEOUT = 10.0  # [s] for the server to start or to end
LONGEST_REQUEST = 512  # [characters]
REQUEST_QUEUE = 64  # requests between two updates
SEND_TIMEOUT = 5.0  # [s] for one message to one client; then that client is let go
REQUEST_INTERVAL = 0.05  # [s] between requests of one client; more of them wait
MOST_CLIENTS = 32  # clients at a time
# Scores
NEEDED_TIME = 10.0  # [s] to act, that a person needs: the median of reactions
BEFORE_CONTACT = 300.0  # [s] an alert that no contact follows in this time is false
