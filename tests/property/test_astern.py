"""A propeller whose thrust is known ahead alone: at no door does it push the ship ahead when it turns astern."""

import importlib.util
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import narrows as nw
from narrows.model.data_range import DataRange

KVLCC2 = nw.published("yasukawa2015_kvlcc2")
FREE = {"u": 1.0, "surge": "free", "contact": "none", "duration": 5.0, "dt": 0.1}


class Astern:
    """A law that orders full astern."""

    def parameters(self) -> dict[str, float]:
        return {"n": -5.0}

    def memory(self, start: Any) -> dict[str, Any]:
        return {}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        return {"revolutions": at.n}, {}


DOORS = {
    "a voyage": lambda: nw.simulate(KVLCC2, revolutions=-1.0, **FREE),
    "a law": lambda: nw.simulate(KVLCC2, revolutions=1.0, controller=Astern(), **FREE),
    "a fleet": lambda: nw.ensemble(KVLCC2, revolutions=[1.0, -1.0], **FREE),
    "forces": lambda: KVLCC2.forces(u=1.0, revolutions=-1.0),
    "columns of forces": lambda: KVLCC2.forces(u=np.ones(2), revolutions=np.array([1.0, -1.0])),
    "rates": lambda: nw.derivative(KVLCC2, {"u": 1.0}, revolutions=-1.0),
    "slopes": lambda: nw.sensitivities(KVLCC2, ["u"], revolutions=-1.0, **FREE),
    "a linear system": lambda: nw.control.linearize(KVLCC2, 0.0, 1.0, revolutions=-1.0),
    "a steady course": lambda: nw.steady_course(KVLCC2, u=1.0, revolutions=-1.0),
    "a regulator": lambda: nw.control.regulator(KVLCC2, 0.0, 1.0, revolutions=-1.0),
    "a predictive helm": lambda: nw.control.PredictiveHelm(KVLCC2, 0.0, 1.0, revolutions=-1.0).begin(),
}


@pytest.mark.parametrize("door", DOORS)
def test_revolutions_astern_are_refused(door: str) -> None:
    with pytest.raises(nw.InputError, match="known ahead only"):
        DOORS[door]()


def test_a_fleet_under_a_law_takes_them_for_a_stopped_propeller() -> None:
    fleet = nw.ensemble(KVLCC2, revolutions=0.0, controller=Astern(), **FREE)
    stopped = nw.simulate(KVLCC2, revolutions=0.0, **FREE)
    assert fleet["u_end"].item() == pytest.approx(stopped.u[-1], abs=1e-9)


def test_an_exported_file_takes_them_for_a_stopped_propeller(tmp_path: Path) -> None:
    nw.export.write_python(KVLCC2, tmp_path / "ship.py", surge="free", contact="none")
    spec = importlib.util.spec_from_file_location("astern_ship", tmp_path / "ship.py")
    ship = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(ship)
    constants, state, rates = ship.prepare(ship.MODEL), ship.rest(), []
    state[ship.U] = 1.0
    for turns in (-1.0, 0.0):
        inputs = ship.AT_REST
        inputs.revolutions = turns
        rates.append(ship.rates(state, inputs, constants))
    np.testing.assert_array_equal(*rates)


def test_way_astern_is_noted_of_voyages_and_fleets() -> None:
    """Banks and rudder of the published DTC are known ahead; a ship that comes to go astern is noted from there."""
    model, told = nw.published("mikkelsen2025_dtc"), {"y": 0.2, "duration": 2.0, "dt": 0.1}
    words = "way astern of -1 m/s is outside the data (ahead alone)"
    assert words in nw.simulate(model, u=-1.0, **told).summary()
    assert "astern" not in nw.simulate(model, u=1.0, **told).summary()
    fleet = nw.ensemble(model, u=[1.0, -1.0], **told)
    assert "50.0% of these voyages begin or end with a way astern outside the data (ahead alone)." in fleet.notes
    tested = replace(model, data_range=DataRange(speed=(0.5, 1.0)))
    assert "way astern of -1 m/s is outside the data (0.5 to 1 m/s)" in nw.simulate(tested, u=-1.0, **told).summary()
    backed = nw.simulate(KVLCC2, u=0.1, surge="free", contact="none", X=-2000.0, duration=20.0, dt=0.1)
    assert backed.u[-1] < 0
    assert "astern" in " ".join(backed.notes)


def test_way_astern_is_noted_at_the_other_doors(tmp_path: Path) -> None:
    """Or refused: steady courses, envelopes and helms are those of a ship ahead."""
    model = nw.published("mikkelsen2025_dtc")
    words = "Beyond the data: way astern -1 m/s; they covered ahead alone."
    force = nw.bank_force(model, 0.5, -1.0)
    assert (words in force.notes, int(force.beyond) & 1) == (True, 1)
    assert words in nw.stability(model, u=-1.0).notes
    assert "astern" not in nw.stability(model, u=1.0).notes
    nw.export.write_python(model, tmp_path / "ship.py")
    ship = runpy.run_path(str(tmp_path / "ship.py"))
    state, constants = ship["rest"](), ship["prepare"](ship["MODEL"])
    for speed, bit in ((-1.0, 1), (1.0, 0)):
        state[ship["U"]] = speed
        assert int(ship["beyond"](state, constants)) == bit
    kcs = nw.published("estimated_kcs")
    for refused in (nw.steady_course, lambda one, u: nw.safe_envelope(one, u=np.array([u]))):
        with pytest.raises(nw.InputError, match="over 0"):
            refused(kcs, u=-1.0)
