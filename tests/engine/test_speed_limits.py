"""Speed limits of sections against the envelope of the same canal, and the rudder of the turn by another door."""

from dataclasses import replace

import numpy as np
import pytest
from cases import deep, waterway_for
from cases import steered as unranged

import narrows as nw
from narrows.model.data_range import DataRange

SPEEDS = np.linspace(0.2, 1.2, 6)
RESERVE = 0.4


def steered() -> nw.Model:
    """The ship of the other tests, as if its tests had covered every speed, offset and section."""
    return replace(unranged(), data_range=DataRange(*((0.0, 1e6),) * 6))


@pytest.fixture(scope="module")
def way() -> nw.Waterway:
    return deep(waterway_for("steered"), "steered")


@pytest.fixture(scope="module")
def limits(way: nw.Waterway) -> list[tuple[float, float]]:
    return nw.speed_limits(steered(), way, [s * way.line.length for s in (0.1, 0.5)], reserve=RESERVE, u=SPEEDS)


def test_a_limit_is_the_envelopes_or_what_the_bend_leaves(way: nw.Waterway, limits: list[tuple[float, float]]) -> None:
    model = steered()
    for place, speed in limits:
        local = replace(model, configuration=replace(model.configuration, canal=way.canal(place)))
        alone = nw.safe_envelope(local, np.array([-float(way.section(place).middle)]), SPEEDS, reserve=RESERVE)
        turn = nw.control.linearize(model, 0.0, speed, waterway=way, at=place).course["rudder"]
        most = (1 - RESERVE) * model.configuration.gear.limit
        assert abs(float(turn)) <= most
        top = float(alone.highest_speed()[0])
        assert speed <= top + 1e-12
        if speed < top:
            faster = nw.control.linearize(model, 0.0, speed + top / 24, waterway=way, at=place).course["rudder"]
            assert not abs(float(faster)) <= most


def test_no_place_is_refused(way: nw.Waterway) -> None:
    with pytest.raises(nw.InputError, match="no place"):
        nw.speed_limits(steered(), way, [])


def test_a_model_of_unknown_ranges_has_no_limit(way: nw.Waterway) -> None:
    with pytest.raises(nw.InputError, match="does not give the tested ranges"):
        nw.speed_limits(unranged(), way, [0.5 * way.line.length], u=SPEEDS)


def test_a_line_that_no_speed_holds_says_why(way: nw.Waterway) -> None:
    place = 0.5 * way.line.length
    with pytest.raises(nw.InputError, match="along the way"):
        nw.speed_limits(steered(), way, [place], y=float(way.section(place).middle) + 3.3, u=SPEEDS)
