"""Planning tests: which runs a tank should make next so that the bank's coefficients become known."""

from narrows.experiment_design.candidates import Tank as Tank
from narrows.experiment_design.candidates import candidates as candidates
from narrows.experiment_design.plan import Plan as Plan
from narrows.experiment_design.plan import plan_tests as plan_tests
