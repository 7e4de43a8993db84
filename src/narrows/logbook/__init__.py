"""From a ship's own records to coefficients that its tests did not settle."""

from narrows.logbook.envelope_change import EnvelopeChange as EnvelopeChange
from narrows.logbook.envelope_change import envelope_change as envelope_change
from narrows.logbook.learn_steady import learn_steady as learn_steady
from narrows.logbook.learned_coefficient import LearnedCoefficient as LearnedCoefficient
from narrows.logbook.plan_steady import plan_steady as plan_steady
from narrows.logbook.reading.read_log import read_log as read_log
from narrows.logbook.reading.read_log import stream_log as stream_log
from narrows.logbook.reading.streamed_log import StreamedLog as StreamedLog
from narrows.logbook.sensor_grades import GRADES as GRADES
from narrows.logbook.sensor_grades import SensorGrade as SensorGrade
from narrows.logbook.sensor_grades import SignalGrade as SignalGrade
from narrows.logbook.sensor_grades import sensor_grade as sensor_grade
from narrows.logbook.ship_log import ShipLog as ShipLog
from narrows.logbook.ship_record import ShipRecord as ShipRecord
from narrows.logbook.signals import SIGNALS as SIGNALS
from narrows.logbook.signals import Signal as Signal
from narrows.logbook.steady_conditions import SteadyConditions as SteadyConditions
from narrows.logbook.steady_fit import SteadyFit as SteadyFit
from narrows.logbook.steady_plan import PlannedLeg as PlannedLeg
from narrows.logbook.steady_plan import SteadyPlan as SteadyPlan
from narrows.logbook.steady_readings import ReadingErrors as ReadingErrors
from narrows.logbook.steady_readings import SteadyReadings as SteadyReadings
from narrows.logbook.steady_readings import steady_readings as steady_readings
