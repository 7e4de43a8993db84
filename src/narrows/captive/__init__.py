"""Captive tests: tables and raw records in, checked columns in SI out."""

from narrows.captive.read import read_captive as read_captive
from narrows.captive.read import stream_captive as stream_captive
from narrows.captive.synthetic import HarmonicRun as HarmonicRun
from narrows.captive.synthetic import StraightRun as StraightRun
from narrows.captive.synthetic import Tank as Tank
from narrows.captive.synthetic import twin as twin
from narrows.captive.tests import CaptiveTests as CaptiveTests
