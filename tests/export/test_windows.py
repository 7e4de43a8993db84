"""The library for Windows of an FMU, run by wine beside the package's own voyage."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from exported import model_of

import narrows as nw
import narrows.export.fmu

pytest.importorskip("ziglang", reason="ziglang is not installed: nothing here builds for Windows")
fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
WINE = shutil.which("wine64") or shutil.which("wine")
START = {"x": 6.0, "y": 0.4, "psi": 0.02, "u": 1.0, "v": 0.0, "r": 0.0}
STEPS, DT = 200, 0.05


@pytest.mark.skipif(WINE is None, reason="wine is not here to run the library for Windows with")
def test_windows_sails_the_voyage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    builds = [build for build in narrows.export.fmu.builds_here() if build[0] == "win64"]
    monkeypatch.setattr(narrows.export.fmu, "builds_here", lambda fmi: builds)
    nw.export.write(model_of("paper"), tmp_path / "ship.fmu", dt=DT)
    with zipfile.ZipFile(tmp_path / "ship.fmu") as packed:
        packed.extract("binaries/win64/ship.dll", tmp_path)
    description = fmpy.read_model_description(str(tmp_path / "ship.fmu"))
    places = {one.name: one.valueReference for one in description.modelVariables}
    headers = Path(narrows.export.fmu.__file__).with_name("fmi")
    source, program = Path(__file__).with_name("windows_co_simulation.c"), tmp_path / "sail.exe"
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-std=c99", f"-I{headers}"]
    subprocess.run([*zig, source, "-o", program], check=True)
    told = [str(value) for name, start in START.items() for value in (places[name], start)]
    library = "binaries\\win64\\ship.dll"
    done = subprocess.run(
        [WINE, program, library, description.guid, str(STEPS), str(DT), *told], cwd=tmp_path, text=True, check=True,
        stdout=subprocess.PIPE, env={**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"},
    )  # fmt: skip
    rows = np.array([line.split() for line in done.stdout.splitlines()], float)
    voyage = nw.simulate(model_of("paper"), **START, duration=STEPS * DT, dt=DT)
    expected = np.stack([getattr(voyage, name)[1 : STEPS + 1] for name in START], axis=1)
    np.testing.assert_allclose(rows, expected, rtol=1e-12, atol=1e-12)
