"""``beyond`` of exported ships has the bits of an untested section of the water, as ``simulate`` names it."""

import json
import runpy
import shutil
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compiled import CompiledShip, fields, needs_compiler, pointer
from exported import bent, model_of, states
from fmus import imported

import narrows as nw
import narrows.export.fmu
from narrows.export.passport import passport
from narrows.model.data_range import DataRange
from narrows.model.water import speeds_afloat
from narrows.simulation.ship import along_waterway

NODE, OCTAVE = shutil.which("node"), shutil.which("octave")
SECTION = DataRange(width_to_beam=(11.5, 12.5), depth_to_draft=(1.0, 1.9))
IN_NODE = """import * as ship from "./ship.mjs";
const water = ship.canal === undefined ? [] : [ship.canal];
const constants = ship.prepare({ ...ship.model, ...%s });
console.log(JSON.stringify(%s.map((state) => ship.beyond(state, constants, ...water))));
"""


def narrow(width: float) -> nw.Model:
    """The 400 m ship of 58.8 m beam, whose bank force comes from tests with W/B of 8 to 12.2."""
    return nw.published("estimated_400m").with_canal(width=width)


@pytest.mark.parametrize(("width", "bit"), [(300.0, 16), (600.0, 0)])
def test_a_canal_of_an_untested_width(width: float, bit: int, tmp_path: Path) -> None:
    nw.export.write(narrow(width), tmp_path / "ship.py")
    ship = runpy.run_path(str(tmp_path / "ship.py"))
    at = ship["rest"]()
    at[ship["U"]] = 4.0
    assert ship["beyond"](at, ship["prepare"](ship["MODEL"])) == bit
    assert any("W/B of 5.1 is outside" in note for note in nw.simulate(narrow(300.0), u=4.0, duration=5.0).notes)
    if OCTAVE is not None:
        nw.export.write(narrow(width), tmp_path / "vessel.m")
        call = "[~, ~, b] = vessel([4 0 0 0 0 0 0]', []); printf('%d', b)"
        done = subprocess.run(
            [OCTAVE, "--norc", "--no-gui", "--eval", call], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.stdout == str(bit), done.stderr


BITS = 16 + 32 + 128


def bits_of(model: nw.Model, section: dict[str, Any], u: np.ndarray) -> np.ndarray:
    """Width, depth and bottom by the rules of ``simulate``."""
    values = {**model.configuration.values(), **section}
    bits = 16 * SECTION.outside("width_to_beam", values["width"] / values["beam"])
    bits = bits + 32 * SECTION.outside("depth_to_draft", values["depth"] / values["draft"])
    return np.asarray(bits + 128 * (u > np.minimum(*speeds_afloat(values))), int)


CHANGED = ({}, {"width": 6.0}, {"depth": 0.22}, {"width": 6.5, "beam": 0.55, "draft": 0.14, "length": 6.0})


@needs_compiler
@pytest.mark.parametrize(
    ("curved", "changes"), [(False, CHANGED), (True, ({}, {"beam": 0.55, "draft": 0.2}))], ids=["canal", "waterway"]
)
def test_the_section_at_the_place_of_the_ship(curved: bool, changes: Any, tmp_path: Path) -> None:
    """In C, Python and JavaScript, along a waterway and in the model's canal, also after a change of parameters."""
    model, at = replace(model_of("steered"), data_range=SECTION), states("steered", 60, x=60.0)
    water, section = {"waterway": bent("steered")} if curved else {}, {}
    if curved:
        section = along_waterway(bent("steered"), model, "corners").section(at[:, 0])
    right = [bits_of(model, {**section, **changed}, at[:, 4]).tolist() for changed in changes]
    compiled = CompiledShip(model, tmp_path, **water)
    known, usual = fields((tmp_path / "ship.h").read_text(encoding="utf-8"), "parameters"), compiled.parameters.copy()
    nw.export.write(model, tmp_path / "ship.py", **water)
    for changed, bits in zip(changes, right, strict=True):
        compiled.parameters[:] = usual
        for name, value in changed.items():
            compiled.parameters[known.index(name)] = value
        compiled.set()
        assert [compiled.library.beyond(pointer(state)) & BITS for state in at.copy()] == bits
        module = runpy.run_path(str(tmp_path / "ship.py"))
        vars(module["MODEL"]).update(changed)
        constants = module["prepare"](module["MODEL"])
        assert (module["beyond"](at.T, constants, module.get("CANAL")) & BITS).tolist() == bits
    if NODE is None:
        pytest.skip("no node is here to run the exported module")
    nw.export.write(model, tmp_path / "ship.mjs", **water)
    for changed, bits in zip(changes, right, strict=True):
        (tmp_path / "run.mjs").write_text(IN_NODE % (json.dumps(changed), json.dumps(at.tolist())), encoding="utf-8")
        done = subprocess.run([NODE, "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
        assert [own & BITS for own in json.loads(done.stdout)] == bits


def test_every_bit_of_the_section_is_seen_by_these_tests() -> None:
    model, u = model_of("steered"), states("steered", 60, x=60.0)[:, 4]
    seen = np.bitwise_or.reduce([np.bitwise_or.reduce(bits_of(model, changed, u)) for changed in CHANGED])
    assert seen == BITS
    assert bits_of(model, {}, u).tolist() != bits_of(model, CHANGED[2], u).tolist()


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_follows_its_parameters(fmi: int, tmp_path: Path) -> None:
    model = replace(model_of("paper"), data_range=SECTION)
    nw.export.write(model, tmp_path / "ship.fmu", fmi=fmi)
    with imported(tmp_path / "ship.fmu") as fmu:
        fmu.start({"y": 0.0, "u": 0.8, "parameters.width": 7.0})
        assert fmu.whole("beyond") & BITS == bits_of(model, {"width": 7.0}, np.array(0.8))
        fmu.step(0.0, 0.1)
        fmu.set(**{"parameters.width": 6.0})
        fmu.step(0.1, 0.1)
        assert fmu.whole("beyond") & BITS == bits_of(model, {"width": 6.0}, np.array(0.8))


def test_the_file_names_the_ranges_that_it_does_not_know(tmp_path: Path) -> None:
    nw.export.write(nw.published("mikkelsen2025_dtc"), tmp_path / "bank.h", kind="bank-force")
    nw.export.write(narrow(300.0), tmp_path / "ship.h")
    bank, ship = ((tmp_path / name).read_text(encoding="utf-8") for name in ("bank.h", "ship.h"))
    assert "32 depth (not known, sets no bit: speed ahead, heading up to 45 deg, depth)" in bank
    assert "32 depth (not known, sets no bit: heading, yaw rate), 128 bottom" in ship
    assert "The model gives no tested range of heading, yaw rate." in ship


def test_the_tests_of_an_estimated_ship_are_those_of_other_ships() -> None:
    lines = list(passport(narrow(300.0)))
    assert any(line.startswith("The other ships' tests covered: ") for line in lines)
    assert not any(line.startswith("Its tests") for line in lines)


def test_a_ship_without_a_bank_force_and_without_verdicts_says_so() -> None:
    lines = list(passport(nw.published("yasukawa2015_kvlcc2")))
    assert lines[0].endswith("motion without a bank force, by the terms mmg.")
    assert "How well tests determine its coefficients is not known: the model has no verdicts." in lines
    assert "motion between two banks" in next(passport(narrow(300.0)))


@pytest.mark.parametrize("name", ["ship.h", "ship.fmu", "ship.tex"])
def test_every_file_names_the_speed_at_which_the_ship_touches_the_bottom(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(narrows.export.fmu, "builds_here", lambda fmi: ())
    model = narrow(300.0)
    nw.export.write(model, tmp_path / name)
    packed = zipfile.is_zipfile(tmp_path / name)
    text = (
        zipfile.ZipFile(tmp_path / name).read("documentation/passport.txt").decode()
        if packed
        else (tmp_path / name).read_text(encoding="utf-8")
    )
    fast = min(speeds_afloat(model.configuration.values()))
    assert (
        f"This file does not model the bottom. From {fast:.4g} m/s the ship touches it or chokes the section." in text
    )
