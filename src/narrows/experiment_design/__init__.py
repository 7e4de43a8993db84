"""Optimal experiment design: the next runs of a tank to identify the bank."""

from narrows.experiment_design.information import Tank as Tank
from narrows.experiment_design.information import candidates as candidates
from narrows.experiment_design.plan import Plan as Plan
from narrows.experiment_design.plan import plan_tests as plan_tests
