"""The paper's simulations, and what an independent reckoning of them gave."""

from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from narrows.report.voyage_figures import distances_figure, paths_figure
from narrows.studies.mikkelsen2025 import Reproduction


def test_the_bank_makes_the_pair_unstable(dtc: nw.Model) -> None:
    found = nw.stability(dtc, u=1.0).eigenvalue.values.ravel()
    assert found[0] == pytest.approx(complex(0.260, 0.248), abs=0.001)
    assert found[1] == pytest.approx(complex(0.260, -0.248), abs=0.001)


def test_the_hull_is_course_unstable_without_a_bank(dtc: nw.Model) -> None:
    assert nw.stability(dtc, bank=False).eigenvalue.values.ravel()[0] == pytest.approx(0.163, abs=0.001)


def test_bank_stiffness(dtc: nw.Model) -> None:
    paper = Reproduction(dtc, None, {}, {})  # type: ignore[arg-type]
    assert paper.stiffness == pytest.approx(0.120603, abs=5e-7)


def test_the_reproduction_gives_its_numbers_beside_the_printed_ones(dtc: nw.Model, twin_fit: nw.Fit) -> None:
    """Of two readings of contact here, of four in the study."""
    starts = np.linspace(2.0, 2.6, 7)
    readings = {
        contact: nw.ensemble(dtc, y=starts, duration=duration, contact=contact)
        for contact, duration in (("corners", 120.0), ("midship", 1.0))
    }
    paper = Reproduction(dtc, twin_fit, {}, readings)
    near = readings["corners"]["side"].to_numpy() > 0
    assert paper.switches["corners"] == starts[np.flatnonzero(~near)[-1] + 1]
    assert paper.switches["midship"] is None
    assert f"grounds on the near bank from y(0) = {paper.switches['corners']:.2f} m: corners" in paper.summary()
    assert "grounds on the near bank nowhere: midship" in paper.summary()
    told = paper.to_dict()
    assert [row["printed"] for row in told["coefficients"]] == list(dtc.coefficients.values())
    assert paper.to_dataframe().loc["b_bank", "value"] == twin_fit.coefficients["b_bank"]
    assert told["eigenvalues"]["without"][0][0] == pytest.approx(0.163, abs=0.001)
    assert sum(row["ours"] for row in told["shapley"] if row["name"].startswith("b_")) == pytest.approx(1.0, abs=0.05)
    assert told["notes"] == paper.notes
    sailed = replace(paper, voyages={y: nw.simulate(dtc, y, 1.0, duration=5.0) for y in (0.5, 1.0)})
    paths, distances = paths_figure(sailed).axes[0], distances_figure(sailed).axes[0]
    assert sum(len(line.get_xdata()) == len(sailed.voyages[0.5].t) for line in paths.lines) == 2
    edge = (7.0 - 0.572) / 2
    np.testing.assert_allclose(distances.lines[0].get_xdata(), edge - starts)
    np.testing.assert_allclose(distances.lines[0].get_ydata(), readings["corners"]["distance"])


def switch(model: nw.Model, **options) -> float:
    """The start beyond which it grounds on the near bank."""
    y = np.linspace(2.0, 2.6, 121)
    side = nw.ensemble(model, y=y, duration=120.0, **options)["side"].to_numpy()
    return float(y[np.argmax(side > 0)])


def test_switch_to_the_near_bank_by_corners(dtc: nw.Model) -> None:
    """About 2.35 m, where the paper has about 2.0; reported, not bent."""
    assert switch(dtc) == pytest.approx(2.35, abs=0.02)


def test_coriolis_moves_the_switch(dtc: nw.Model) -> None:
    heavy = replace(dtc, configuration=replace(dtc.configuration, ship=replace(dtc.configuration.ship, mass=245.0)))
    assert switch(heavy, coriolis=True) == pytest.approx(2.29, abs=0.02)


def test_by_midship_she_never_grounds_to_starboard_from_afar(dtc: nw.Model) -> None:
    ends = nw.ensemble(dtc, y=np.linspace(0.3, 2.5, 45), contact="midship", duration=120.0)
    assert not (ends["side"] > 0).any()


def test_from_a_tenth_of_a_metre_she_grounds(dtc: nw.Model) -> None:
    assert nw.simulate(dtc, y=0.1, duration=120.0).outcome.kind == "grounded"


def test_the_papers_surge_force_holds_the_papers_speed(dtc: nw.Model) -> None:
    """12.6 N against 12.6 |u|u: straight ahead the speed stays 1 m/s."""
    voyage = nw.simulate(dtc, y=0.0, surge="free", surge_inertia=300.0, X=12.6, duration=10.0)
    np.testing.assert_allclose(voyage.u, 1.0, rtol=1e-12)
