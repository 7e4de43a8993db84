"""Short ways that a notebook user looks for, each against the longer way that it stands for."""

import io
from contextlib import redirect_stdout
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import narrows as nw
from logs import kvlcc2
from tables import short_twin

DTC = nw.published("mikkelsen2025_dtc")


@pytest.fixture(scope="module")
def fit() -> nw.Fit:
    return nw.identify(short_twin())


def test_a_fit_saves_its_model(fit: nw.Fit, tmp_path) -> None:
    fit.save(tmp_path / "fit.toml")
    assert nw.load_model(tmp_path / "fit.toml") == fit.model
    fit.save(tmp_path / "fit.json")
    assert "coefficients" in (tmp_path / "fit.json").read_text()


def test_variance_inflation_is_the_inverse_of_the_correlations(fit: nw.Fit) -> None:
    """Marquardt (1970): the diagonal of the inverse of the columns' correlation matrix."""
    motion = {**fit.tests.configuration.values(), **fit.tests.columns}
    columns = {term.name: np.broadcast_to(term.column(motion), fit.tests.rows) for term in fit.terms.forces["N"]}
    names = [name for name, column in columns.items() if np.ptp(column) > 0]
    assert len(names) > 3
    assert all(1 <= fit.vif[name] < np.inf for name in names if name in fit.vif)
    assert set(fit.vif) <= set(fit.terms.names)
    assert fit.vif["c_r"] == fit.diagnostics.overall["N"].vif["c_r"]


def test_residuals_are_drawn_over_estimates(fit: nw.Fit) -> None:
    figure = fit.plot_residuals()
    assert len(figure.axes) == 3
    drawn = np.concatenate([line.get_ydata() for line in figure.axes[1].lines[:-1]])
    assert np.sort(drawn) == pytest.approx(np.sort(fit.residuals["Y"]))
    with pytest.raises(nw.InputError, match="force = 'K' is unknown"):
        fit.plot_residuals(force="K")
    timeless = nw.read_captive(fit.tests.to_dataframe().drop(columns="t"), fit.tests.configuration)
    assert len(nw.identify(timeless).plot_residuals(force="Y").axes) == 1


def test_a_film_ends_where_the_voyage_does(tmp_path) -> None:
    voyage = nw.simulate(DTC, y=0.5, u=1.0)
    assert voyage.final.t == voyage.outcome.time
    assert voyage.final.y == voyage.outcome.state["y"]
    voyage.animate(tmp_path / "v.gif", seconds=0.3)
    with Image.open(tmp_path / "v.gif") as film:
        assert film.n_frames == 4
    voyage.animate(tmp_path / "v.html", seconds=0.2)
    assert "<img" in (tmp_path / "v.html").read_text()
    for wrong in ({"path": "v.mp4"}, {"seconds": 0.0}):
        with pytest.raises(nw.InputError):
            voyage.animate(**wrong)


def test_circles_and_zigzags_are_those_of_the_trials() -> None:
    model, speed = kvlcc2(), 1.179
    trials = nw.sail_trials(model, speed, 35.0, ((20, 20),))
    circle, zigzag = nw.turning_circle(model, -35, speed), nw.zigzag(model, 20, 20, speed)
    assert circle.advance == trials.turning["-35"].advance
    assert circle.voyage.y[-1] < 0
    assert zigzag.overshoots_deg == trials.zigzags["+20/20"].overshoots_deg
    for one in (circle, zigzag):
        assert len(one.plot().axes) == 1
    same = nw.turning_circle(model, -np.radians(35), speed), nw.zigzag(model, 20, np.radians(20), speed)
    assert same[0].advance == pytest.approx(circle.advance)
    assert same[1].overshoots_deg == pytest.approx(zigzag.overshoots_deg)
    assert all("was read in radians" in one.notes[-1] for one in same)
    assert nw.turning_circle(model, "-35deg", speed).tactical_diameter == circle.tactical_diameter
    with pytest.raises(nw.InputError, match="must be a finite number"):
        nw.turning_circle(model, "hard over")


def test_a_trial_approaches_at_a_steady_speed() -> None:
    """Froude's law: with revolutions that keep the approach, a ship turns alike at two speeds far from its own."""
    kcs = nw.published("estimated_kcs")
    slow, usual = (nw.turning_circle(kcs, speed=speed) for speed in (4.0, 6.0))
    assert any("keep the approach speed" in note for note in slow.notes)
    assert slow.advance == pytest.approx(usual.advance, rel=0.02)
    assert slow.voyage.u.max() == pytest.approx(4.0, rel=0.001)
    ahead = replace(kcs.in_open_water(), configuration=slow.voyage.configuration)
    straight = nw.simulate(ahead, u=4.0, duration=600.0, contact="none", surge="free")
    assert straight.u[-1] == pytest.approx(4.0, rel=0.001)


def test_revolutions_of_another_speed_are_told_with_those_that_keep_it(cli) -> None:
    """A propeller at the revolutions of service speed makes the rudder of a slow ship too strong."""
    kcs = nw.published("estimated_kcs")
    fitting = nw.self_propulsion(kcs, 6.0)
    words = f"{fitting:.3g} keep 6 m/s straight ahead"
    for revolutions, told in (({}, True), ({"revolutions": fitting}, False)):
        voyage = nw.simulate(kcs, u=6.0, duration=1.0, **revolutions)
        fleet = nw.ensemble(kcs, u=[6.0], y=[0.0, 5.0], duration=1.0, **revolutions)
        for notes in (voyage.notes, fleet.attrs["notes"].splitlines()):
            assert any(words in note for note in notes) is told
    code, out, _ = cli("simulate", "estimated_kcs", "--speed", "6m/s", "--duration", 1, "--revolutions", fitting)
    assert (code, words in out) == (0, False)
    assert not any("keep" in note for note in nw.simulate(nw.published("yasukawa2015_kvlcc2"), u=1.179).notes)


def test_a_fleet_draws_its_map() -> None:
    fleet = nw.ensemble(DTC, y=[0.2, 0.5], u=[0.8, 1.0])
    drawn, part = fleet.plot(), fleet.isel(u=0).plot()
    assert any("DTC" in text.get_text() for text in drawn.texts)
    assert not any("DTC" in text.get_text() for text in part.texts)
    assert "not tested: extrapolated" in [text.get_text() for text in part.axes[0].get_legend().get_texts()]


def test_lqr_solves_the_riccati_equation() -> None:
    linear = nw.control.linearize(nw.published("estimated_kcs"), y=0.0, u=6.0, surge="held")
    Q, R = np.diag([1e-4, 1.0, 0.0, 0.0]), np.array([[1.0]])
    K, S, poles = nw.control.lqr(linear, Q, R, "rudder")
    A, B = linear.matrices("rudder")
    residual = A.T @ S + S @ A - S @ B @ np.linalg.solve(R, B.T @ S) + Q
    assert np.abs(residual).max() < 1e-9 * np.abs(S).max()
    assert K == pytest.approx(np.linalg.solve(R, B.T @ S))
    assert poles.real.max() < 0
    assert linear.poles() == pytest.approx(linear.eigenvalues())
    for wrong in ((np.eye(3), R), (Q, [[0.0]])):
        with pytest.raises(nw.InputError):
            nw.control.lqr(linear, *wrong, "rudder")


def test_a_model_goes_out_by_suffix(tmp_path) -> None:
    DTC.export(tmp_path / "dtc.h")
    nw.export.write(DTC, tmp_path / "other.h")
    assert DTC.to_c().count("double") > 3
    assert (tmp_path / "dtc.h").read_text().replace("dtc", "other").count("other") > 3
    DTC.to_c(tmp_path / "c.h")
    DTC.export(tmp_path / "dtc.tex")
    for path, options in (("dtc.xyz", {}), ("dtc.h", {"colour": 1})):
        with pytest.raises(nw.InputError):
            DTC.export(tmp_path / path, **options)


def test_a_waterway_reads_itself(tmp_path) -> None:
    from dataclasses import replace

    way = replace(nw.straight_waterway(nw.Canal(100.0, 12.0), 5000.0), origin=(5.0, 52.0))
    nw.write_waterway(way, tmp_path / "w.geojson")
    assert (
        nw.Waterway.from_geojson(tmp_path / "w.geojson").summary() == nw.read_waterway(tmp_path / "w.geojson").summary()
    )


def test_versions_are_printed() -> None:
    with redirect_stdout(io.StringIO()) as printed:
        nw.show_versions()
    assert {"narrows", "python", "numpy"} <= {line.split()[0] for line in printed.getvalue().splitlines()}


def test_a_figure_needs_no_table_that_nobody_asked_for(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    """The table of a fleet of millions may not fit in memory."""
    voyage = nw.simulate(DTC, y=0.2, u=1.0, duration=5.0)
    monkeypatch.setattr(type(voyage), "to_dataframe", None)
    assert voyage.plot().axes
    assert voyage.plot(str(tmp_path / "a.png")).axes


@pytest.mark.parametrize("style", [{"figsize": 3}, {"color": "no colour"}])
def test_a_style_that_matplotlib_refuses_is_answered(style) -> None:
    voyage = nw.simulate(DTC, y=0.2, u=1.0, duration=5.0)
    with pytest.raises(nw.InputError, match="plot cannot draw this"):
        voyage.plot(**style)


def test_an_animation_needs_a_file_name() -> None:
    with pytest.raises(nw.InputError, match="nameless"):
        nw.simulate(DTC, y=0.2, u=1.0, duration=5.0).animate("")
