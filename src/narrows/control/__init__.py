"""Control: steady courses, the revolutions that keep a speed, the track pilot."""

from narrows.control.self_propulsion import self_propulsion as self_propulsion
from narrows.control.steady_course import steady_course as steady_course
from narrows.control.track_pilot import track_pilot as track_pilot
