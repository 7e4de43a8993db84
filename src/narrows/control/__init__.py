"""Control: steady courses, linear systems about them, propeller revolutions for a speed, helms."""

from typing import Any

from narrows.base.aliases import part_named
from narrows.control.closed_loop import ClosedLoop as ClosedLoop
from narrows.control.closed_loop import closed_loop as closed_loop
from narrows.control.linear_system import LinearSystem as LinearSystem
from narrows.control.predictive import PredictiveHelm as PredictiveHelm
from narrows.control.regulator import HeldLine as HeldLine
from narrows.control.regulator import Regulator as Regulator
from narrows.control.regulator import RegulatorWeights as RegulatorWeights
from narrows.control.regulator import lqr as lqr
from narrows.control.regulator import regulator as regulator
from narrows.control.steady_course import linearize as linearize
from narrows.control.steady_course import steady_course as steady_course
from narrows.simulation.initial_state import self_propulsion as self_propulsion


def __getattr__(name: str) -> Any:
    return part_named(name, "control", globals())
