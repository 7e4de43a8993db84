"""Predictive control: plans of the rudder within its limits, clear of the banks, bends seen ahead."""

from narrows.control.predictive.predictive_helm import PredictiveHelm as PredictiveHelm
