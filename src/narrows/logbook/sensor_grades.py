"""Errors of a ship's sensors, by grade: noise, correlated noise, and constant errors of a record."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from narrows.base.errors import check_choice
from narrows.base.results import BaseSummary
from narrows.logbook.ship_log import check_signals
from narrows.quantities.names import DEGREE, KNOT
from narrows.ship.checks import check_sizes


@dataclass(frozen=True)
class SignalGrade:
    """Errors of one signal.

    Raises an InputError where a number is negative or not finite, or there is no noise or period at all.

    Examples
    --------
    >>> nw.SignalGrade(noise=0.5, period=1.0).noise
    0.5
    """

    noise: float  #: Standard deviation from reading to reading [unit of the signal]
    period: float = 1.0  #: Time between two readings [s]
    wander: float = 0.0  #: Standard deviation of an error of a first-order process [unit of the signal]
    memory: float = 60.0  #: Its correlation time [s]
    zero: float = 0.0  #: Standard deviation of an error that is constant over a record [unit of the signal]

    def __post_init__(self) -> None:
        check_sizes(self, over=("noise", "period", "memory"))


@dataclass(frozen=True, repr=False)
class SensorGrade(BaseSummary):
    """A ship's sensors.

    Raises an InputError where a name is no signal's.

    Examples
    --------
    >>> nw.SensorGrade("tank", "", {"y": nw.SignalGrade(0.01)}).name
    'tank'
    """

    name: str  #: Name of the grade
    words: str  #: Its meaning
    #: By the names of ``SIGNALS``; what is not there is not measured
    signals: Mapping[str, SignalGrade] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_signals(self.signals)

    def summary(self) -> str:
        return f"{self.name}: {self.words}; measures {', '.join(self.signals)}"


# Assumed but for these. IMO A.424(XI), gyro-compasses: to 0.75 deg at rest, 1.0 deg under way, times the secant of the
# latitude; standard deviations are about half of it (nippon.zaidan.info/seikabutsu/2000/00402/contents/006.htm,
# checked). IMO A.526(13), rate-of-turn indicators: to 0.5 deg/min and 5 % of what is shown
# (ajishnavigator.blogspot.com/2011/10/imo-performance-standards-for-rot.html, checked). AIS: heading in whole degrees
# and no rudder, by the form of the message (ais_msg_2.html at vislab-ccom.unh.edu, checked). The zeros of x and y are
# those of the antenna and of the banks as charted.
RTK = SensorGrade(
    "rtk",
    "a pilot's own unit, two antennas with corrections, and the rudder's indicator by wire",
    {
        **dict.fromkeys(("y", "x"), SignalGrade(0.05, zero=0.3)),
        "psi": SignalGrade(0.05 * DEGREE, zero=0.1 * DEGREE),
        "r": SignalGrade(0.008 * DEGREE, wander=0.002 * DEGREE),
        **dict.fromkeys(("v_ground", "u_ground"), SignalGrade(0.02, wander=0.01, memory=100.0)),
        "rudder": SignalGrade(0.1 * DEGREE, zero=0.3 * DEGREE),
    },
)
VDR = SensorGrade(
    "vdr",
    "what a voyage data recorder keeps: GNSS, gyro, rate of turn, rudder indicator",
    {
        **dict.fromkeys(("y", "x"), SignalGrade(0.7, wander=1.0, memory=300.0, zero=2.0)),
        "psi": SignalGrade(0.15 * DEGREE, wander=0.2 * DEGREE, memory=600.0, zero=0.5 * DEGREE),
        "r": SignalGrade(0.01 * DEGREE, wander=0.004 * DEGREE, memory=60.0),
        "u": SignalGrade(0.1, zero=0.1),
        "rudder": SignalGrade(0.4 * DEGREE, zero=0.5 * DEGREE),
    },
)
AIS = SensorGrade(
    "ais",
    "what the ship broadcasts: position, heading in whole degrees, every ten seconds, without the rudder",
    {
        **dict.fromkeys(("y", "x"), SignalGrade(1.5, period=10.0, wander=1.0, memory=300.0, zero=3.0)),
        "psi": SignalGrade(0.3 * DEGREE, period=10.0, wander=0.2 * DEGREE, memory=600.0, zero=1.0 * DEGREE),
        "speed_over_ground": SignalGrade(0.05 * KNOT, period=10.0, wander=0.05 * KNOT, memory=300.0),
    },
)
GRADES = {grade.name: grade for grade in (RTK, VDR, AIS)}  # Grades by name, the best first


def sensor_grade(sensors: str | SensorGrade, known: Mapping[str, SensorGrade] = GRADES) -> SensorGrade:
    if isinstance(sensors, SensorGrade):
        return sensors
    check_choice("sensors", sensors, known)
    return known[sensors]
