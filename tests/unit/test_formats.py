"""The suffix of a file decides its form, or is refused before anything is computed; what was written is printed."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.io import loadmat

import narrows as nw

DTC = "mikkelsen2025_dtc"
VOYAGE = ("simulate", DTC, "--y", "0.5", "--duration", "20")
MAP = ("map", DTC, "--y", "0:1:3", "--speed", "0.8:1:2", "--duration", "5", "--dt", "0.5")


@pytest.fixture(scope="module")
def bend(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bend of a river, of the size of a model basin."""
    path = tmp_path_factory.mktemp("bend") / "bend.geojson"
    angle = np.linspace(0, 0.6, 25)
    rings = {"centreline": 60.0, "starboard": 56.5, "port": 63.5}
    metres = {role: np.stack([60 - radius * np.cos(angle), radius * np.sin(angle)]) for role, radius in rings.items()}
    features = [
        {
            "type": "Feature",
            "properties": {"role": role},
            "geometry": {"type": "LineString", "coordinates": (points.T / 111_195 + [8.0, 0.001]).tolist()},
        }
        for role, points in metres.items()
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def read(path: Path) -> np.ndarray:
    """The offsets in a file, whatever its form."""
    if path.suffix == ".nc":
        return xr.load_dataset(path, engine="scipy")["y"].to_numpy()
    if path.suffix == ".mat":
        return loadmat(path)["y"].ravel()
    return (pd.read_csv(path) if path.suffix == ".csv" else pd.read_parquet(path))["y"].to_numpy()


@pytest.mark.parametrize("suffix", [".nc", ".csv", ".parquet", ".mat"])
def test_a_voyage_in_every_form(suffix: str, tmp_path: Path, cli) -> None:
    path = tmp_path / f"v{suffix}"
    for _ in range(2):  # What is there is replaced.
        code, out, err = cli(*VOYAGE, "-o", path)
        assert (code, err) == (0, "")
        assert out.endswith(f"wrote {path}\n")
    expected = nw.simulate(nw.published(DTC), 0.5, duration=20.0).y
    np.testing.assert_allclose(read(path), expected, rtol=1e-12)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_a_voyage_as_json_holds_how_it_ended_and_the_voyage(tmp_path: Path, cli) -> None:
    cli(*VOYAGE, "-o", tmp_path / "v.json")
    told = json.loads((tmp_path / "v.json").read_text())
    voyage = nw.simulate(nw.published(DTC), 0.5, duration=20.0)
    assert told["outcome"] == voyage.outcome.kind
    np.testing.assert_allclose(told["data"]["variables"]["y"]["values"], voyage.y, rtol=1e-12)


@pytest.mark.parametrize("suffix", [".nc", ".csv", ".parquet", ".mat", ".json"])
def test_a_map_in_every_form(suffix: str, tmp_path: Path, cli) -> None:
    path = tmp_path / f"m{suffix}"
    code, out, _ = cli(*MAP, "-o", path)
    assert code == 0
    assert out.endswith(f"wrote {path}\n")
    if suffix == ".json":
        told = json.loads(path.read_text())
        assert told["coordinates"]["y"]["values"] == [0.0, 0.5, 1.0]
        assert np.shape(told["variables"]["distance"]["values"]) == (3, 2)
    else:
        assert set(read(path)) == {0.0, 0.5, 1.0}


@pytest.mark.parametrize("what", ["voyage", "map"])
def test_caveats_travel_with_the_file(what: str, tmp_path: Path, cli) -> None:
    verb = VOYAGE if what == "voyage" else MAP
    for suffix in (".nc", ".parquet", ".mat", ".json"):
        assert cli(*verb, "-o", tmp_path / f"file{suffix}")[0] == 0
    parts = (
        xr.load_dataset(tmp_path / "file.nc", engine="scipy").attrs,
        pd.read_parquet(tmp_path / "file.parquet").attrs,
    )
    arrays = loadmat(tmp_path / "file.mat")
    told = [*(" ".join(map(str, part.values())) for part in parts), " ".join(str(arrays[name]) for name in arrays)]
    told.append((tmp_path / "file.json").read_text())
    assert ["outside the data" in words for words in told] == [True] * 4


def test_a_track_on_the_map(bend: Path, tmp_path: Path, cli) -> None:
    arguments = (*VOYAGE, "--waterway", bend, "--x", "2")
    for suffix in (".geojson", ".csv"):
        assert cli(*arguments, "-o", tmp_path / f"v{suffix}")[0] == 0
    frame = pd.read_csv(tmp_path / "v.csv")
    line, end = json.loads((tmp_path / "v.geojson").read_text())["features"]
    points = np.array(line["geometry"]["coordinates"])
    np.testing.assert_allclose(points, frame[["longitude", "latitude"]], atol=1e-8)
    assert end["geometry"]["coordinates"] == points[-1].tolist()
    assert len(line["properties"]["t"]) == len(line["properties"]["heading_deg"]) == len(points)


def test_a_track_is_where_the_waterway_says(bend: Path) -> None:
    voyage = nw.simulate(nw.published(DTC), 0.0, waterway=nw.read_waterway(bend), duration=0.1, x=2.0)
    track = voyage.dataset()
    east, north = np.array([track.longitude.values[0] - 8.0, track.latitude.values[0] - 0.001]) * 111_195
    angle = 2.0 / 60
    assert [east, north] == pytest.approx([60 - 60 * np.cos(angle), 60 * np.sin(angle)], abs=0.03)
    assert track.heading_deg.values[0] == pytest.approx(np.degrees(angle), abs=0.2)  # It turns to starboard from north.


def test_a_track_needs_a_place_on_earth(tmp_path: Path, cli) -> None:
    code, _, err = cli(*VOYAGE, "-o", tmp_path / "v.geojson")
    assert code == 2
    assert "needs a waterway with a position on earth" in err
    assert "latitude" not in nw.simulate(nw.published(DTC), duration=1.0).dataset()


REFUSED = {
    "a voyage": ((*VOYAGE, "-o"), "v.xls", "cannot write a xls file here; name it .nc, .csv"),
    "a voyage without a suffix": ((*VOYAGE, "-o"), "v", "cannot write a nameless file here"),
    "a map": ((*MAP, "-o"), "m.geojson", "cannot write a geojson file here"),
    "a chart": ((*MAP, "--plot"), "m.gif", "name it .png, .svg, .pdf"),
    "a model": (("scale", DTC, "--length", "355", "-o"), "m.csv", "name it .toml"),
    "runs": (("plan", "nowhere.toml", "-o"), "runs.nc", "name it .csv"),
    "an envelope": (("envelope", DTC, "-o"), "e.txt", "name it .nc"),
    "trials": (("trials", "yasukawa2015_kvlcc2", "--speed", "1m/s", "-o"), "t.nc", "name it .csv"),
    "a report": (("identify", "nowhere.csv", "--ship", "no.toml", "--report"), "r.pdf", "name it .html"),
    "a waterway": (("waterway", "nowhere.geojson", "-o"), "w.kml", "name it .geojson"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_other_names_are_refused_before_anything_is_done(case: str, tmp_path: Path, cli) -> None:
    arguments, name, said = REFUSED[case]
    code, out, err = cli(*arguments, tmp_path / name)
    assert (code, out) == (2, "")
    assert said in err
    assert not list(tmp_path.iterdir())


def test_trials_and_explanations_go_into_tables(ship_file: Path, tmp_path: Path, cli) -> None:
    code, out, _ = cli(
        "trials", "yasukawa2015_kvlcc2", "--speed", "1.179m/s", "--zigzags", "10/10", "-o", tmp_path / "t.csv"
    )
    assert code == 0
    assert "wrote " in out
    assert len(pd.read_csv(tmp_path / "t.csv")) > 2


def test_a_heading_between_two_steps_may_pass_north(bend: Path) -> None:
    voyage = nw.simulate(
        nw.published(DTC), 0.0, waterway=nw.read_waterway(bend), duration=1.0, x=2.0, psi=-2.0 / 60 - 0.002, r=0.02
    )
    told = voyage.dataset().heading_deg.values
    assert told.max() > 359.0
    assert told.min() < 1.0
    between = voyage.at((voyage.t[1:] + voyage.t[:-1]) / 2).heading_deg
    assert ((between < 1.0) | (between > 359.0)).all()
