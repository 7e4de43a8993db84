"""Estimation: position, motion and external disturbances of a ship from its sensors and its model."""

from typing import Any

from narrows.base.aliases import part_named
from narrows.estimation.consistency import Consistency as Consistency
from narrows.estimation.consistency import consistency as consistency
from narrows.estimation.estimator import Estimator as Estimator
from narrows.estimation.sensors import *  # noqa: F403  its sensors are those of ``__all__`` there
from narrows.estimation.states import Estimate as Estimate
from narrows.estimation.states import EstimatedTrack as EstimatedTrack
from narrows.estimation.states import Prior as Prior
from narrows.estimation.states import ProcessNoise as ProcessNoise


def __getattr__(name: str) -> Any:
    return part_named(name, "estimation", globals())
