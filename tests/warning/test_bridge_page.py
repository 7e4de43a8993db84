"""The monitor's page over real sockets: what is told, who may come, and what becomes of an acknowledgement."""

import contextlib
import json
import math
import socket
from collections.abc import Iterator
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path

import numpy as np
import pytest
from shown_page import ALARM, BANK, HANDSHAKE, NOW, SHIP, Watched, asked, estimate, forecast, soon
from transit import canal

import narrows as nw
import narrows.warning.page as page_room
from narrows.warning import settings
from narrows.warning.alerts.alert import OTHER_DEPTH, SENSORS, AlertState, Condition, Priority
from narrows.warning.monitoring.watched_transit import NOT_AVAILABLE, clearances
from narrows.warning.page.bridge_page import (
    CROWDED,
    MALFORMED,
    NO_ORIGIN,
    NO_TOKEN,
    UPDATES,
    BridgePage,
    address_of,
    packed,
    refusal,
    update_of,
)

FAN_MEMBERS = 32  # ships of the fan


def test_messages_are_what_their_schema_says() -> None:
    validator = pytest.importorskip("jsonschema", reason="of the group test").Draft202012Validator
    schema = json.loads((Path(page_room.__file__).parent / "messages.json").read_text(encoding="utf-8"))
    validator.check_schema(schema)
    monitored = Watched()
    statuses = [
        monitored.status(forecast()), monitored.status(forecast(60.0, 14.0), conditions=ALARM),
        monitored.status(now=None),
        monitored.status(conditions={SENSORS["heading"]: Condition(Priority.WARNING, "no heading for 11 s")}),
    ]  # fmt: skip
    told = [update_of(monitored, status, 1.7e9) for status in statuses]
    said = [{"kind": kind, "sentence": "It is over."} for kind in ("refused", "ended")]
    for message in [*told, *said]:
        assert list(validator(schema).iter_errors(json.loads(packed(message)))) == []
    assert [message["status"] for message in told] == ["clear", "alarm", NOT_AVAILABLE, NOT_AVAILABLE]
    assert told[1]["alerts"][0]["may"] == ["acknowledge", "silence"]
    assert told[2]["scene"] is None
    assert told[3]["scene"]["fan"] is None


def test_a_doubt_is_told_beside_the_headline() -> None:
    said = Watched().status(
        forecast(60.0, 14.0), conditions={**ALARM, OTHER_DEPTH: Condition(Priority.CAUTION, "Beyond.")}
    )
    assert said.headline == ALARM[BANK].text
    assert said.caveats == ("Beyond.",)
    assert Watched().status(forecast()).headline == "No contact within 120 s, rudder as it is"


def test_nothing_is_clear_while_a_last_chance_or_a_contact_comes() -> None:
    words = [Watched().status(forecast(*told)).word for told in ((), (100.0, 46.0))]
    assert words == ["clear", "watch"]
    assert Watched().status(replace(forecast(), as_is=0.02)).word == "watch"
    assert Watched().status(forecast(), now=NOW | {"y": 110.0}).word == "watch"  # 18 m to starboard
    assert Watched().status(forecast(), now=NOW | {"y": 105.0}).word == "clear"
    wrong = Watched().status(forecast(wrong_order=32.5))
    assert (wrong.word, wrong.headline) == ("watch", "32 s to act after a wrong order hard over")


def test_water_to_both_sides_is_that_of_geometry() -> None:
    """Along the line, by hand; at a heading, the corners reach further to both sides alike."""
    room = clearances(SHIP, canal(), estimate(0.0, dict.fromkeys("xyurv", 0.0) | {"x": 800.0, "y": 40.0, "psi": 0.0}))
    assert room[:2] == pytest.approx((150.0 + 40.0 - 16.1, 150.0 - 40.0 - 16.1))
    turned = clearances(SHIP, canal(), estimate(0.0, dict.fromkeys("xyurv", 0.0) | {"x": 800.0, "y": 40.0, "psi": 0.2}))
    assert turned.port - room.port == pytest.approx(turned.starboard - room.starboard)
    assert turned.port < room.port - 20.0


def test_bow_and_stern_have_their_own_water_and_speed() -> None:
    """By hand: a ship at a heading of 0.1 that turns; the bow is 11.5 m nearer to starboard and goes there faster."""
    now = {"x": 800.0, "y": 40.0, "psi": 0.1, "u": 4.0, "v": 0.2, "r": 0.002}
    room, reach = clearances(SHIP, canal(), estimate(0.0, now)), 115.0 * math.sin(0.1)
    for end, place in ((room.bow, 1), (room.stern, -1)):
        assert end.starboard == pytest.approx(150.0 - 40.0 - place * reach - 16.1 * math.cos(0.1), abs=1e-6)
        assert end.port == pytest.approx(150.0 + 40.0 + place * reach - 16.1 * math.cos(0.1), abs=1e-6)
        across = 4.0 * math.sin(0.1) + (0.2 + place * 115.0 * 0.002) * math.cos(0.1)
        assert end.speed == pytest.approx(across)


def test_the_scene_lies_in_the_canal() -> None:
    """The banks as far apart as they are, and the ship as far from them as it says."""
    monitored = Watched()
    status = monitored.status(forecast())
    scene = update_of(monitored, status, 0.0)["scene"]
    (port, starboard), pose = scene["banks"], scene["ship"]["pose"]
    across = [((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5 for a, b in zip(port, starboard, strict=True)]
    assert across == pytest.approx([300.0] * len(across), abs=0.3)
    nearest = min(((pose[0] - a[0]) ** 2 + (pose[1] - a[1]) ** 2) ** 0.5 for a in starboard)
    assert nearest == pytest.approx(90.0, abs=1.0)
    assert scene["fan"]["members"][0][0] == pose[:2]


def test_what_diverges_is_not_drawn() -> None:
    monitored = Watched()
    status = monitored.status(forecast())
    tracks = status.forecast.tracks
    tracks.fan[3, 5:] = np.nan
    assert len(update_of(monitored, status, 0.0)["scene"]["fan"]["members"]) == FAN_MEMBERS - 1
    tracks.as_is[-1] = np.inf
    assert update_of(monitored, status, 0.0)["scene"]["fan"] is None


@pytest.mark.parametrize(
    ("token", "host", "origin", "sentence"),
    [
        ("secret", "127.0.0.1:8765", None, ""), ("secret", "localhost:8765", "http://localhost:8765", ""),
        ("secret", "[::1]:8765", "http://[::1]:8765", ""), ("secret", "192.168.1.20", "https://192.168.1.20", ""),
        (f"{socket.gethostname()}", "127.0.0.1", None, NO_TOKEN), ("", "127.0.0.1", None, NO_TOKEN),
        ("sécret", "127.0.0.1", None, NO_TOKEN), ("", "rebound.example", "http://rebound.example", NO_TOKEN),
        ("secret", "127.0.0.1:8765", "http://127.0.0.1:9999", NO_ORIGIN),
        ("secret", "127.0.0.1:8765", "https://elsewhere.example", NO_ORIGIN),
        ("secret", "127.0.0.1", "null", NO_ORIGIN),
    ],
)  # fmt: skip
def test_who_may_come(token: str, host: str, origin: str | None, sentence: str) -> None:
    assert refusal("secret", token, host, origin) == sentence


def test_tokens_are_new_and_not_shown() -> None:
    one = BridgePage()
    assert len(one.token) >= 24
    assert one.token != BridgePage().token
    assert one.token not in repr(one)


@pytest.fixture(scope="module")
def page() -> BridgePage:
    pytest.importorskip("websockets", reason="of the extra monitor")
    return BridgePage("secret")


@pytest.fixture(scope="module")
def host(page: BridgePage) -> Iterator[str]:
    with page.open() as address:
        yield address.removeprefix("http://").split("/")[0]


def got(host: str, path: str, **heads: str) -> tuple[int, str, dict[str, str]]:
    connection = HTTPConnection(host)
    connection.request("GET", path, headers=heads)
    answer = connection.getresponse()
    text, kept = answer.read().decode(), dict(answer.getheaders())
    connection.close()
    return answer.status, text, kept


def test_the_page_asks_for_its_token_and_for_nothing_from_elsewhere(host: str) -> None:
    assert got(host, "/")[:2] == (403, NO_TOKEN)
    status, shown, heads = got(host, "/?token=secret")
    assert status == 200
    assert "default-src 'none'" in heads["Content-Security-Policy"]
    parts = [word.split('"')[0] for word in shown.split('="assets/')[1:]]
    for part in [*parts, "canal.js", "words.js"]:
        status, told, _ = got(host, f"/assets/{part}")
        assert status == 200
        assert "://" not in told.replace("${scheme}//", "")
    wrong = ("index.html", "..%2fpage_app.py", "x.js")
    assert [got(host, f"/assets/{name}")[0] for name in wrong] == [404] * 3


def refused(host: str, path: str, more: str = "") -> str:
    """What a websocket is answered."""
    name, port = host.split(":")
    with socket.create_connection((name, int(port))) as line:
        line.settimeout(5.0)
        line.sendall(HANDSHAKE.format(path=path, host=host, more=more).encode())
        answer = b""
        while b"\r\n\r\n" not in answer or not answer.endswith(b"."):
            answer += (piece := line.recv(4096))
            if not piece:
                break
    return answer.decode()


def test_a_websocket_is_refused_with_a_sentence(host: str) -> None:
    elsewhere = "Origin: https://elsewhere.example\r\n"
    for answer, sentence in {
        refused(host, UPDATES): NO_TOKEN,
        refused(host, f"{UPDATES}?token=wrong"): NO_TOKEN,
        refused(host, f"{UPDATES}?token=secret", elsewhere): NO_ORIGIN,
    }.items():
        assert " 403 " in answer.splitlines()[0]
        assert answer.endswith(sentence)


def test_a_crowd_is_refused(host: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settings, "MOST_CLIENTS", 0)
    assert refused(host, f"{UPDATES}?token=secret").endswith(CROWDED)


def test_requests_that_never_end_exhaust_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A cap on open connections, and a time-out for a request that is not finished; then a browser comes in again."""
    monkeypatch.setattr(settings, "MOST_CONNECTIONS", 20)
    monkeypatch.setattr(settings, "HEADER_TIMEOUT", 0.5)
    pytest.importorskip("websockets", reason="of the extra monitor")
    with BridgePage("secret").open() as address:
        exhaust(address.removeprefix("http://").split("/")[0])


def exhaust(host: str) -> None:
    name, port = host.split(":")
    lines = [socket.create_connection((name, int(port)), 5.0) for _ in range(60)]
    for line in lines:
        line.settimeout(5.0)
        with contextlib.suppress(OSError):
            line.sendall(b"GET /?token=secret HTTP/1.1\r\nHost: ")
    with contextlib.suppress(OSError):
        assert all(line.recv(1) == b"" for line in lines)
    assert soon(lambda: got(host, "/?token=secret")[0] == 200)
    for line in lines:
        line.close()


def request(monitored: Watched, command: str = "acknowledge", **changed: int) -> str:
    alert = monitored.desk[BANK]
    seen = {"identifier": alert.identifier, "instance": alert.instance, "revision": alert.revision}
    return json.dumps({"command": command, **seen, **changed})


def test_an_acknowledgement_on_the_page_is_that_of_the_bridge(page: BridgePage, host: str) -> None:
    """Told, acknowledged once; a copy of it, a wrong one and what is none are refused in words."""
    from websockets.sync.client import connect

    monitored, changed = Watched(), "That alert is over, or has changed since it was asked for; look at it again."
    told = monitored.status(forecast(60.0, 14.0), conditions=ALARM)
    with connect(f"ws://{host}{UPDATES}?token=secret", origin=f"http://{host}") as line:
        assert soon(lambda: page._server.connections)
        page.publish(monitored, told, 1.7e9)
        assert json.loads(line.recv(5.0))["alerts"][0]["state"] == "unacknowledged"
        copy = request(monitored)
        line.send(copy)
        assert [alert.state for alert in soon(lambda: asked(page, monitored))] == [AlertState.ACKNOWLEDGED]
        for text, sentence in {
            copy: changed,
            request(monitored): "The alert is acknowledged, so there is nothing to acknowledge.",
            request(monitored, "silence"): "The alert is acknowledged, so there is nothing to silence.",
            request(monitored, instance=3): changed,
            request(monitored, identifier=7): changed,
            "[" * 400: MALFORMED,
        }.items():
            line.send(text)
            if sentence is not MALFORMED:
                soon(lambda: not page.requests._waiting.empty())
            assert asked(page, monitored) == []
            assert json.loads(line.recv(5.0)) == {"kind": "refused", "sentence": sentence}


def test_a_page_that_cannot_be_served_says_so(page: BridgePage, host: str) -> None:
    port = int(host.split(":")[1])
    with pytest.raises(nw.InputError, match="give another --port or --host"), page.open(port=port):
        pass
    with pytest.raises(nw.InputError, match="cannot be served at nowhere"), page.open("nowhere.invalid"):
        pass
    assert [address_of(name) for name in ("0.0.0.0", "::1", "10.0.0.2")] == ["127.0.0.1", "[::1]", "10.0.0.2"]
