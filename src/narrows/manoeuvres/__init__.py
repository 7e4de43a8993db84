"""Standard manoeuvres, and what is read off them: turning circles, zigzags."""

from narrows.manoeuvres.manoeuvring_trials import Trials as Trials
from narrows.manoeuvres.manoeuvring_trials import sail_trials as sail_trials
from narrows.manoeuvres.measures import Turning as Turning
from narrows.manoeuvres.measures import overshoots as overshoots
from narrows.manoeuvres.measures import turning_circle as turning_circle
