"""KVLCC2 learned from the free-running zigzags of HSVA: those left out, and the circles of MARIN."""

from pathlib import Path

import numpy as np
import pytest

import narrows as nw

MAPPING = Path(__file__).parents[2] / "examples" / "hsva_kvlcc2.toml"
# Advance and tactical diameter over the length, of MARIN's raw records (SIMMAN 2008), by the rudder to starboard [deg].
CIRCLES = {35.0: (3.09, 3.34), -35.0: (3.01, 3.08)}


@pytest.mark.slow
@pytest.mark.parametrize(("chosen", "missed_deg"), [(slice(None), 3.0), (slice(1, None, 3), 7.0)], ids=["all", "four"])
def test_whole_zigzags_and_the_circles_of_another_tank_are_predicted(
    chosen: slice, missed_deg: float, shared_data: Path
) -> None:
    files = sorted((shared_data / "kvlcc2_free_running" / "hsva").glob("*.dat"))[chosen]
    log = nw.read_log(files, mapping=MAPPING)
    kept = ("x", "y", "psi", "r", "rudder", "revolutions")
    records = [nw.ShipRecord(one.name, {name: one[name] for name in kept}) for one in log]
    fit = nw.learn(nw.published("yasukawa2015_kvlcc2"), records, sensors="basin", spread=0.2)
    assert np.degrees(fit.whole_missed["after"]) < missed_deg
    assert fit.whole_missed["after"] < 0.75 * fit.whole_missed["nomoto"]
    for rudder, measured in CIRCLES.items():
        circle = nw.turning_circle(fit.model, rudder, 1.179)
        found = circle.advance / 7.0, circle.tactical_diameter / 7.0
        assert found == pytest.approx(measured, rel=0.07)
