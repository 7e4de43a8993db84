"""Connections that break, lines in pieces; the page's scene by geometry."""

import json
import math
from collections.abc import Generator
from types import SimpleNamespace

import numpy as np
import pytest
from shown_page import NOW, Watched, estimate, forecast
from transit import canal

from narrows.warning.inputs.listening import Connection, Piece, connection_of, split_lines
from narrows.warning.page.bridge_page import address_of, request_of, scene


class Stopper:
    """An event that counts what it waited for, and is set after so many waits."""

    def __init__(self, waits: int) -> None:
        self.waited: list[float] = []
        self.left = waits

    def is_set(self) -> bool:
        return self.left <= 0

    def wait(self, seconds: float) -> None:
        self.waited.append(seconds)
        self.left -= 1


def test_a_broken_connection_is_tried_again_each_time_twice_as_late_up_to_30_s() -> None:
    """Half a second first; what arrives begins anew."""
    outcomes = iter(["", "", b"piece", "", *[""] * 7])

    def opened() -> Generator[Piece]:
        outcome = next(outcomes)
        if not outcome:
            raise ConnectionRefusedError("refused")
        yield Piece(b"")
        yield Piece(outcome)
        raise ConnectionResetError("reset")

    stop = Stopper(11)
    told = list(Connection(False, opened).pieces(stop))  # type: ignore[arg-type]
    assert told == [Piece(b"piece")]
    assert stop.waited == [0.5, 1.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0, 30.0]


def test_lines_come_whole_whatever_the_pieces() -> None:
    assert split_lines(b"$A,1\r\n$B", False) == ([b"$A,1"], b"$B")
    assert split_lines(b"$B,2\r", False) == ([b"$B,2"], b"")
    assert split_lines(b"\n$C", True) == ([b"$C"], b"")
    assert split_lines(b"x" * 4096, False) == ([], b"x" * 4096)
    assert split_lines(b"y" + b"x" * 4096, False) == ([], b"x" * 4096)


@pytest.mark.parametrize(("address", "whole"), [("udp://:10110", True), ("tcp://127.0.0.1:10110", False)])
def test_a_datagram_is_whole_and_a_stream_is_not(address: str, whole: bool) -> None:
    assert connection_of(address).whole is whole


@pytest.mark.parametrize(
    ("host", "address"),
    [("0.0.0.0", "127.0.0.1"), ("::", "127.0.0.1"), ("", "127.0.0.1"), ("::1", "[::1]"), ("bridge", "bridge")],
)
def test_an_address_of_a_page_can_be_opened(host: str, address: str) -> None:
    assert address_of(host) == address


def test_a_request_has_at_most_512_letters() -> None:
    text = json.dumps({"command": "silence", "identifier": 10110, "instance": 1, "revision": 2})
    assert request_of(text + " " * (512 - len(text)))
    assert request_of(text + " " * (513 - len(text))) is None


@pytest.mark.parametrize(
    ("x", "first", "last"), [(3200.0, 2400.0, 5600.0), (300.0, 0.0, 2700.0), (5900.0, 5100.0, None)]
)
def test_the_banks_are_drawn_from_800_m_astern_to_2400_m_ahead_each_20_m(
    x: float, first: float, last: float | None
) -> None:
    """In metres north and east to a decimetre, as the waterway lies on the map."""
    now, length = {**NOW, "x": x}, canal().line.length
    drawn = scene(Watched(), Watched().status(forecast(), now=now))
    last = length if last is None else last
    along = np.linspace(first, last, round((last - first) / 20.0) + 1)
    for side, own, limit in zip((-1, 1), drawn["banks"], drawn["limits"], strict=True):
        east_north, _ = canal().to_map(along, np.full(len(along), side * 150.0), 0.0)
        np.testing.assert_allclose(np.array(own), east_north[:, ::-1], atol=0.051)
        np.testing.assert_allclose(np.array(limit), np.array(own), atol=1e-9)
    east_north, heading = canal().to_map(x, 60.0, 0.05)
    np.testing.assert_allclose(drawn["ship"]["pose"], [*east_north[::-1], heading], atol=0.051)
    assert abs(drawn["ship"]["pose"][2] - heading) < 6e-5
    middle, _ = canal().to_map(x, 0.0, 0.0)
    np.testing.assert_allclose(drawn["middle"][:2], middle[::-1], atol=0.051)


def test_a_fan_begins_at_the_ship_and_has_only_whole_tracks() -> None:
    told = forecast(60.0, 14.0)
    told.tracks.fan[3, 5, 1] = math.nan
    drawn = scene(Watched(), Watched().status(told))["fan"]
    assert drawn["times"] == list(range(5, 121, 5))
    assert len(drawn["members"]) == 31
    pose = scene(Watched(), Watched().status(told))["ship"]["pose"]
    assert all(track[0] == pose[:2] for track in drawn["members"])
    end, heading = canal().to_map(NOW["x"] + 120 * NOW["u"], 60.0, 0.05)
    np.testing.assert_allclose(drawn["likely"][-1], [*end[::-1], heading], atol=0.051)
    told.tracks.escape[-1, 0] = math.nan
    assert scene(Watched(), Watched().status(told))["fan"] is None


def test_no_place_is_no_scene() -> None:
    assert scene(Watched(), SimpleNamespace(estimate=estimate(0.0, None))) is None  # type: ignore[arg-type]
