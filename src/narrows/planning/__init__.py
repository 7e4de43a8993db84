"""Planning tests: which runs a tank should make next so that the bank's coefficients become known."""

from narrows.planning.candidates import Tank as Tank
from narrows.planning.candidates import candidates as candidates
from narrows.planning.plan import Plan as Plan
from narrows.planning.plan import plan_tests as plan_tests
