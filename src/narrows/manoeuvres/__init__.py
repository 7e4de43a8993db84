"""Standard manoeuvres and their measures: turning circles, zigzags, stopping tests."""

from narrows.manoeuvres.manoeuvring_trials import Trials as Trials
from narrows.manoeuvres.manoeuvring_trials import Turning as Turning
from narrows.manoeuvres.manoeuvring_trials import ZigzagTest as ZigzagTest
from narrows.manoeuvres.manoeuvring_trials import overshoots as overshoots
from narrows.manoeuvres.manoeuvring_trials import sail_trials as sail_trials
from narrows.manoeuvres.manoeuvring_trials import turning_circle as turning_circle
from narrows.manoeuvres.manoeuvring_trials import zigzag as zigzag
from narrows.manoeuvres.stopping import StoppingTest as StoppingTest
from narrows.manoeuvres.stopping import crash_stop as crash_stop
