"""``narrows learn MODEL LOG...``: a log in, a model that knows more out; exit 1 where the log does not tell."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from test_learn import WRONG, begun, errs, mistaken, records

import narrows as nw
from faults import seldom
from logs import kvlcc2

SCHEMA = json.loads((Path(nw.__file__).parent / "schemas" / "learn.json").read_text())
BASIN = ("--sensors", "basin", "--spread", "0.1")


def known_but(spread: dict[str, float]) -> nw.Model:
    """The mistaken ship, all of whose coefficients but some are held for exact."""
    names = mistaken().terms.names
    return replace(mistaken(), covariance=np.diag([spread.get(name, 0.0) ** 2 for name in names]))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Models of any and of few errors, a log with zigzags, and one of a ship that goes straight ahead."""
    folder = tmp_path_factory.mktemp("learn")
    mistaken().save(folder / "ship.toml")
    known_but(errs(*WRONG, "N_r")).save(folder / "few.toml")
    known_but({"N_rrr": 0.01 * abs(mistaken()["N_rrr"])}).save(folder / "known.toml")
    nw.ShipLog(tuple(begun()[:2])).to_csv(folder / "zigzags.csv")
    nw.ShipLog((seldom(begun()[0]),)).to_csv(folder / "seldom.csv")
    t = np.arange(0.0, 304.0, 4.0)
    speed = 7.0 + 0.0 * t
    told = {"x": 7.0 * t, "y": 0 * t, "psi": 0 * t, "r": 0 * t, "u": speed, "rudder": 0 * t}
    noise = np.random.default_rng(0)
    quiet = {name: nw.Signal(t, column + 1e-3 * noise.standard_normal(len(t))) for name, column in told.items()}
    nw.ShipLog((nw.ShipRecord("straight", quiet),)).to_csv(folder / "straight.csv")
    (folder / "empty.csv").write_text("t,x,y,heading [deg],rudder [deg]\n")
    unsteered = {name: signal for name, signal in quiet.items() if name != "rudder"}
    nw.ShipLog((nw.ShipRecord("silent", unsteered),)).to_csv(folder / "silent.csv")
    return folder


def test_a_log_makes_a_model_and_a_page(cli, folder: Path) -> None:
    model, page = folder / "learned.toml", folder / "learned.html"
    words = ("--sensors", "basin", "--unchecked", "-o", model, "--report", page)
    code, out, err = cli("learn", folder / "few.toml", folder / "zigzags.csv", *words)
    assert code == 0, err
    assert out.startswith("Learned from 2 records, 6.64 min: learned: ")
    assert f"wrote {model}" in out
    learned = nw.load_model(model)
    assert abs(learned["N_v"] / kvlcc2()["N_v"] - 1) < 0.06
    assert "learned from 2 records of the ship itself (zigzag +20 to zigzag -20, sensors basin" in learned.source.text
    text = page.read_text(encoding="utf-8")
    assert text.count("<svg") == 1
    assert "zigzag +20" in text
    assert "Motion determines only forces over inertia" in text


def test_json_keeps_to_the_schema_and_notes_what_is_doubtful(cli, folder: Path) -> None:
    free = "N_v,N_r"
    words = ("--sensors", "basin", "--free", free, "--json")
    code, out, err = cli("learn", folder / "few.toml", folder / "seldom.csv", *words)
    assert code == 0, err
    told = json.loads(out)
    assert list(Draft202012Validator(SCHEMA).iter_errors(told)) == []
    moved = [c["name"] for c in told["log"]["coefficients"] if c["value"] != c["prior"]]
    assert moved == free.split(",")
    assert f"Only {', '.join(moved)} may change" in out
    assert any(note.startswith("sampling (doubtful)") for note in told["log"]["notes"])


def test_a_log_that_is_not_checked_has_no_doubts(cli, folder: Path) -> None:
    words = ("--spread", "0.01", "--free", "N_rrr", "--unchecked", "--json")
    out = cli("learn", folder / "ship.toml", folder / "seldom.csv", "--sensors", "basin", *words)[1]
    assert not any("doubtful" in note for note in json.loads(out)["log"]["notes"])


def test_a_log_that_does_not_tell_is_exit_1(cli, folder: Path) -> None:
    words = ("--sensors", "basin", "--free", "N_rrr", "--unchecked")
    code, out, _ = cli("learn", folder / "known.toml", folder / "straight.csv", *words)
    assert code == 1
    assert out.startswith("Learned from 1 record, 4.99 min: nothing.")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["{ship}"], "one of LOG, --steady"), ([], "MODEL"),
        (["{ship}", "{log}", "--steady", "x.csv"], "exactly one of"), (["{ship}", "{gone}"], "no such file"),
        (["{ship}", "{log}"], "--spread 0.1"), (["{ship}", "{log}", "{log}"], "is given twice"),
        (["{ship}", "{log}", "--spread", "0.1", "--free", "N_vv,N_w", "--unchecked"], "did you mean"),
        (["{ship}", "{log}", "--spread", "0.1", "--sensors", "gps"], "rtk or vdr or ais or basin"),
        (["{ship}", "{log}", "--waterway", "{gone}"], "gone.csv"), (["{ship}", "{empty}"], "has no signal of a ship"),
        (["{ship}", "{silent}", "--spread", "0.1"], "has no rudder angle"),
        (["{ship}", "--predict-information", "vdr", "-o", "new.toml"], "--output goes with"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_line_and_exit_2(cli, folder: Path, words: list[str], says: str) -> None:
    files = {"ship": folder / "ship.toml"} | {
        name: folder / f"{file}.csv"
        for name, file in (("log", "zigzags"), ("gone", "gone"), ("empty", "empty"), ("silent", "silent"))
    }
    code, _, err = cli("learn", *(word.format(**files) for word in words))
    assert code == 2
    assert says in err


def test_a_rudder_that_counts_the_other_way_is_found_before_the_fit(cli, folder: Path) -> None:
    rudders = [record["rudder"] for record in records()[:2]]
    turned = [
        record.with_signals(rudder=nw.Signal(rudder.t, -rudder.values))
        for record, rudder in zip(records(), rudders, strict=False)
    ]
    nw.ShipLog(tuple(turned)).to_csv(folder / "turned.csv")
    code, _, err = cli("learn", folder / "ship.toml", folder / "turned.csv", *BASIN)
    assert code == 2
    assert "rudder" in err
    assert "--unchecked" in err
    # A model without a prior is refused before the log is checked.
    assert "--spread 0.1" in cli("learn", folder / "ship.toml", folder / "turned.csv")[2]
