"""From a ship's own records to coefficients that its tests did not settle."""

from narrows.logbook.ship_log import ShipLog as ShipLog
from narrows.logbook.ship_record import ShipRecord as ShipRecord
from narrows.logbook.signals import SIGNALS as SIGNALS
from narrows.logbook.signals import Signal as Signal
