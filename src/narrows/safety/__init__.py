"""The safe envelope: how fast, and how far off the centreline, a ship stays controllable."""

from narrows.safety.channel_rules import OutsideRules as OutsideRules
from narrows.safety.channel_rules import outside_rules as outside_rules
from narrows.safety.envelope import safe_envelope as safe_envelope
from narrows.safety.envelope_along import EnvelopeAlong as EnvelopeAlong
from narrows.safety.envelope_along import envelope_along as envelope_along
from narrows.safety.request import Disturbance as Disturbance
from narrows.safety.request import wind_force as wind_force
from narrows.safety.result import MEDIAN as MEDIAN
from narrows.safety.result import SafeEnvelope as SafeEnvelope
from narrows.safety.settings import RESERVE as RESERVE
from narrows.safety.settings import SURE_SHARE as SURE_SHARE
