"""Rules from outside against arithmetic done by hand from their sources."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from narrows.safety.channel_rules import BANKS, CHANNEL_RULES, READ
from narrows.safety.result import exceeded_rules

KNOT = 1852 / 3600  # [m/s] international nautical mile of 1852 m (Monaco, 1929) in an hour

CASES = {
    "a ship of 400 m in 205 x 24 m": nw.Configuration(nw.Ship(399.94, 58.8, 15.85, 0.661), nw.Canal(205.0, 24.0)),
    "the KVLCC2 in 400 x 30 m": nw.Configuration(nw.Ship(320.0, 58.0, 20.8, 0.81), nw.Canal(400.0, 30.0)),
    "the KCS in 300 x 16.2 m": nw.Configuration(nw.Ship(230.0, 32.2, 10.8, 0.65), nw.Canal(300.0, 16.2)),
}
NONE = None
BY_HAND = {
    ("PIANC 121", 8.0): ((47, 23, NONE), (139, 116, 87), (119, 107, 90)),
    ("PIANC 121", 0.0): ((50, 32, 20), (142, 125, 113), (121, 111, 105)),
    ("PIANC 121", 12.0): ((41, 11, NONE), (133, 104, 70), (116, 100, 81)),
    ("UFC 4-150-06", 0.0): ((NONE, NONE, NONE), (90, 90, 78), (89, 89, 82)),
}
"""Offsets [m] at gentle, sloping and steep banks, by the rule and the speed [knots] from which it holds."""


def rows(case: str, bank: str = "steep") -> list[dict]:
    return nw.outside_rules(CASES[case], bank).rows()


@pytest.mark.parametrize("bank", BANKS)
@pytest.mark.parametrize("case", CASES)
def test_offsets_are_those_computed_by_hand(case: str, bank: str) -> None:
    widths = {(row["rule"], row["slowest"]): row for row in rows(case, bank) if row["width"] is not None}
    for key, offsets in BY_HAND.items():
        expected = offsets[list(CASES).index(case)][BANKS.index(bank)]
        row = widths[key]
        assert (row["starboard"] is None) == (expected is None)
        if expected is not None:
            assert round(row["starboard"]) == expected
            assert row["port"] == -row["starboard"]


def test_what_a_rule_asks_for_is_said_where_there_is_less() -> None:
    (ufc,) = [row for row in rows("a ship of 400 m in 205 x 24 m", "gentle") if row["rule"] == "UFC 4-150-06"]
    assert round(ufc["width"]) == 223  # 1.8 + 2 x 1.0 beams of 58.8 m
    summary = nw.outside_rules(CASES["a ship of 400 m in 205 x 24 m"], "gentle").summary()
    assert "UFC 4-150-06: to 10 knots, needs 223 m of water, more than there is." in summary


@pytest.mark.parametrize(
    ("case", "limits"),
    [
        ("a ship of 400 m in 205 x 24 m", {"Suez, other ships": (8.64, 59), "Panama, 1933": (10.0, 68)}),
        ("the KVLCC2 in 400 x 30 m", {"Suez, tanker or bulk carrier": (7.56, 36), "Panama, 1933": (15.0, 72)}),
        ("the KCS in 300 x 16.2 m", {"Suez, other ships": (8.64, 52), "Kiel": (6.48, 39), "Panama, 1933": (12.0, 72)}),
    ],
)
def test_speed_limits_are_those_of_the_canals(case: str, limits: dict) -> None:
    by_rule = {row["rule"]: row for row in rows(case)}
    for rule, (knots, share) in limits.items():
        assert by_rule[rule]["speed_limit"] == pytest.approx(knots, abs=0.005)
        assert round(100 * by_rule[rule]["of_choking"]) == share
        assert by_rule[rule]["of_choking"] * nw.choke_speed(CASES[case]) == pytest.approx(
            by_rule[rule]["speed_limit"] * KNOT
        )


def test_who_is_spoken_of_depends_on_the_ship() -> None:
    """No tanker's limit at 44 ft or less, no Kiel Canal for what is too long for it, 15 km/h there at a small draft."""
    deep, kcs = CASES["a ship of 400 m in 205 x 24 m"], CASES["the KCS in 300 x 16.2 m"]
    assert "Kiel" not in {row["rule"] for row in nw.outside_rules(deep).rows()}
    assert "Suez, tanker or bulk carrier" not in {row["rule"] for row in nw.outside_rules(kcs).rows()}
    light = replace(kcs, ship=replace(kcs.ship, draft=8.0))
    (kiel,) = [row for row in nw.outside_rules(light).rows() if row["rule"] == "Kiel"]
    assert kiel["speed_limit"] * KNOT * 3.6 == pytest.approx(15.0)
    cut = replace(kcs, canal=nw.Canal(91.0, 16.2))
    (panama,) = [row for row in nw.outside_rules(cut).rows() if row["rule"] == "Panama, 1933"]
    assert panama["speed_limit"] == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("rule", "changed", "canal", "knots"),
    [
        # Kiel: to 235.5 m by 32.5 m; 15 km/h, from a draft of 8.5 m on 12 km/h.
        ("Kiel", {"length": 235.4}, 300.0, 12 / 1.852), ("Kiel", {"length": 235.6}, 300.0, None),
        ("Kiel", {"beam": 32.4}, 300.0, 12 / 1.852), ("Kiel", {"beam": 32.6}, 300.0, None),
        ("Kiel", {"draft": 8.4}, 300.0, 15 / 1.852), ("Kiel", {"draft": 8.6}, 300.0, 12 / 1.852),
        # Panama: 15, 12 and 10 knots in reaches of 1000, 800 and 500 ft; in the cut 8 knots, and 6 from 250 ft on.
        ("Panama, 1933", {}, 305.0, 15.0), ("Panama, 1933", {}, 304.0, 12.0), ("Panama, 1933", {}, 244.0, 12.0),
        ("Panama, 1933", {}, 243.0, 10.0), ("Panama, 1933", {}, 153.0, 10.0), ("Panama, 1933", {}, 152.0, 6.0),
        ("Panama, 1933", {"length": 76.3, "beam": 12.0}, 91.0, 6.0),
        ("Panama, 1933", {"length": 76.1, "beam": 12.0}, 91.0, 8.0),
    ],
)  # fmt: skip
def test_limits_begin_where_the_canals_have_them(rule: str, changed: dict, canal: float, knots: float | None) -> None:
    kcs = CASES["the KCS in 300 x 16.2 m"]
    there = replace(kcs, ship=replace(kcs.ship, **changed), canal=nw.Canal(canal, 16.2))
    limits = {row["rule"]: row["speed_limit"] for row in nw.outside_rules(there).rows()}
    assert limits.get(rule) == (None if knots is None else pytest.approx(knots, rel=1e-6))


def test_a_wider_or_a_gentler_water_never_leaves_less() -> None:
    for configuration in CASES.values():
        for narrow, wide in ((replace(configuration, canal=nw.Canal(w, configuration.canal.depth)),
                              replace(configuration, canal=nw.Canal(w + 20, configuration.canal.depth)))
                             for w in (180.0, 250.0, 320.0)):  # fmt: skip
            left = [[_far(row) for row in nw.outside_rules(one).rows() if row["width"]] for one in (narrow, wide)]
            assert all(more >= less for less, more in zip(*left, strict=True))
        kinds = [[_far(row) for row in nw.outside_rules(configuration, bank).rows() if row["width"]] for bank in BANKS]
        assert all(a >= b >= c for a, b, c in zip(*kinds, strict=True))


def _far(row: dict) -> float:
    return -math.inf if row["starboard"] is None else row["starboard"]


def test_walls_that_are_not_alike_leave_offsets_that_are_not() -> None:
    kcs = CASES["the KCS in 300 x 16.2 m"]
    plain, shifted = (nw.outside_rules(kcs, walls=walls).rows()[0] for walls in (None, (160.0, 140.0)))
    assert shifted["port"] == pytest.approx(plain["port"] - 10.0)
    assert shifted["starboard"] == pytest.approx(plain["starboard"] - 10.0)


def test_what_was_not_read_is_not_shown_as_published() -> None:
    rules = nw.outside_rules(CASES["the KCS in 300 x 16.2 m"])
    unread = {rule.name for rule in CHANNEL_RULES if rule.standing != READ}
    assert unread == {"PIANC 121", "USACE EM 1110-2-1613"}
    for name in unread:
        assert any(note.startswith(f"{name}: ") and "memory" in note for note in rules.notes)


def test_a_rule_without_a_source_is_none() -> None:
    for rule in CHANNEL_RULES:
        assert all((rule.source, rule.content))
        assert bool(rule.widths) + bool(rule.speeds) + (rule.rudder_deg is not None) == 1


def test_a_bank_of_no_known_kind_is_refused() -> None:
    with pytest.raises(nw.InputError, match="gentle or sloping or steep"):
        nw.outside_rules(CASES["the KCS in 300 x 16.2 m"], "muddy")


@pytest.fixture(scope="module")
def certain() -> nw.Model:
    """The KCS at full size with a rudder, as if its coefficients were certain."""
    from narrows.captive.measured import measured_files

    turned = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
    tests = nw.read_captive(*measured_files("kcs"), turned).by_condition()["C0101A03"]
    fit = nw.identify(tests, nw.STEERED)
    # Not fit.model: its covariance and verdicts, which take seconds, are those of no certain ship.
    tank = nw.Model(tests.configuration, nw.STEERED, fit.least_squares, data_range=fit.data_range)
    full = nw.scale_model(tank, 230.0, 1025.0, width=300.0, depth=16.2).model
    return full.with_coefficients(b_bank=0.02, c_bank=0.02)


def test_where_ours_is_bolder_a_note_says_so_and_why(certain: nw.Model) -> None:
    """A sure ship is held farther out than the rules let it go, with more than 5 degrees of rudder."""
    offsets, calm = np.array([0.0, 70.0, 95.0]), nw.Disturbance(0.0)
    answer = nw.safe_envelope(certain, offsets, np.array([3.0, 5.0]), disturbance=calm, samples=1)
    farthest = float(answer.data["y"][answer.by_model().any("u")].max())
    assert farthest > 70.0
    (bolder,) = [note for note in answer.notes if note.startswith("The envelope exceeds")]
    names, _, why = bolder.partition(": ")
    assert [name in names for name in ("UFC 4-150-06", "UFC 4-150-06, rudder", "Kiel")] == [True] * 3
    assert "manual steering" in why
    near = nw.safe_envelope(certain, np.array([0.0, 20.0]), np.array([3.0]), disturbance=calm, samples=1)
    assert not any(note.startswith("The envelope exceeds") for note in near.notes)


def test_the_answer_carries_the_rules_into_its_files(certain: nw.Model, tmp_path) -> None:
    answer = nw.safe_envelope(certain, np.array([0.0]), np.array([3.0]), samples=1, bank="gentle")
    assert answer.rules == nw.outside_rules(certain.configuration, "gentle")
    answer.save(tmp_path / "e.nc")
    with xr.open_dataset(tmp_path / "e.nc", engine="scipy") as data:
        again = nw.SafeEnvelope(data.load())
    assert again.rules.rows() == answer.rules.rows()
    dry = replace(certain, configuration=replace(certain.configuration, canal=nw.Canal(300.0)))
    unknown = nw.safe_envelope(dry, np.array([0.0]), np.array([3.0]), samples=1)
    assert math.isnan(unknown.rules.depth)


@pytest.mark.parametrize(("offsets", "exceeds"), [([-10.0, 50.0], True), ([-35.0, 10.0], True), ([-20.0, 20.0], False)])
def test_safe_offsets_beyond_a_rule(offsets: list[float], exceeds: bool) -> None:
    row = {"port": -20.0, "starboard": 20.0, "rule": "A rule", "width": 40.0, "slowest": 0.0, "fastest": None}
    found = {"held": (("y", "u"), np.ones((2, 1))), "rudder": (("y", "u"), np.zeros((2, 1))), "clear": ("u", [True])}
    data = xr.Dataset(found, coords={"y": offsets, "u": [3.0]})
    assert bool(exceeded_rules(data, SimpleNamespace(rows=lambda: [row]), 0.95)) is exceeds
