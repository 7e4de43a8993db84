"""Model predictive control: plans of the rudder within its limits, clear of the banks, with bends ahead."""

from narrows.control.predictive.predictive_helm import PredictiveHelm as PredictiveHelm
