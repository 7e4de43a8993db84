"""Model predictive control: the rudder planned within its limits and clear of the banks, by multiple shooting."""

from narrows.control.predictive.predictive_helm import PredictiveHelm as PredictiveHelm
