"""Stand-ins of the files that a reader of the docs brings: tests, a ship, models of both sizes, a waterway, a chart."""

import json
import shutil
from pathlib import Path

import numpy as np

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.logbook.ship_log import sensor_grade
from narrows.logbook.transits import TransitTwin
from narrows.model.tables import table_named
from narrows.waterway.map_lines import unprojected
from s57 import CANAL_BANK, DEPTH_AREA, Cell, Point
from tables import frame_of
from twins import transits_of

TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
DEPTH = "C0101A02"
LENGTH = 400.0
"""Of the waterway and of the chart [m]."""


def write(folder: Path) -> None:
    """Write them under the names that the pages call them by."""
    table, ship = measured_files("kcs")
    shutil.copy(ship, folder / "ship.toml")
    frame_of(nw.measured_tests("kcs").by_condition()[DEPTH]).to_csv(folder / "tests.csv", index=False)
    terms = table_named("speed+helm")
    model = nw.identify(nw.read_captive(table, ship, TURNED).by_condition()[DEPTH], terms).model
    nw.save_model(model, folder / "model.toml")
    full = nw.scale_model(model, 230.0, 1025.0, width=300.0, depth=16.2).model
    nw.save_model(full, folder / "full.toml")
    (folder / "held.csv").write_text(HELD)
    twin = TransitTwin(full, 4.5, 1800.0)
    # With seed 1 `check_log` finds a delay: in one of twenty logs without a fault it does, by design.
    transits_of(twin, sensor_grade("rtk"), 1, 2).to_csv(folder / "bridge.csv")
    lines = {"centreline": at(0.0), "starboard": at(3.5), "port": at(-3.5)}
    write_lines(folder / "canal.geojson", lines, depth=0.3)
    write_lines(folder / "axis.geojson", {"centreline": at(0.0)})
    write_kml(folder / "banks.kml", {"axis": at(0.0), "right": at(30.0), "left": at(-45.0)})
    write_chart(folder / "1W7RH001.000")
    write_laboratory(folder)
    shutil.copy(Path(__file__).parents[1] / "examples" / "waterway.geojson", folder / "bend.geojson")


HELD = """\
leg,y [m],u [kn],rudder [deg],drift [deg]
1,20.5,8.7,2.9,1.0
2,-19.6,8.6,-1.2,-1.4
3,-20.3,8.7,-1.6,-1.3
4,19.8,8.8,2.6,1.1
"""
"""Of a ship of ``full.toml`` that was held to either side."""
COLUMNS = """\
[columns]
test = "Run"
y = "Ycarr"
psi = "Heading"
X = "Fx"
Y = "Fy"
N = "Mz"

[positive]
y = "port"
"""
"""Of the laboratory whose table ``lab.csv`` is."""


def write_laboratory(folder: Path) -> None:
    """Write a table as a laboratory may: its own names, y to port, degrees, a row of units, semicolons and commas."""
    frame = frame_of(nw.measured_tests("kcs").by_condition()[DEPTH])
    frame = frame.assign(y=-frame.y, **{name: np.degrees(frame[name]) for name in ("psi", "r", "rdot")})
    units = {"x": "m", "y": "mm", "psi": "deg", "u": "m/s", "v": "m/s", "r": "deg/s", "udot": "m/s2", "vdot": "m/s2",
             "rdot": "deg/s2", "heave": "m", "X": "N", "Y": "N", "N": "Nm", "revolutions": "1/s"}  # fmt: skip
    frame = frame.assign(y=frame.y * 1e3)[["test", *units]]
    names = {"test": "Run", "y": "Ycarr", "psi": "Heading", "X": "Fx", "Y": "Fy", "N": "Mz"}
    rows = frame.rename(columns=names).to_csv(index=False, sep=";", decimal=",").splitlines()
    below = ";".join(["", *(f"[{unit}]" for unit in units.values())])
    text = "\n".join(["Towing tank, project 4711", "2014-05-02", "", rows[0], below, *rows[1:], ""])
    (folder / "lab.csv").write_text(text, encoding="utf-8-sig")
    (folder / "columns.toml").write_text(COLUMNS, encoding="utf-8")


def at(aside: float, reach: float = 0.0) -> list[Point]:
    """A line northward, so far to starboard of the middle and beyond both ends [m]."""
    points = np.array([[aside, north] for north in (-reach, LENGTH / 2, LENGTH + reach)])
    return [(float(east), float(north)) for east, north in unprojected(points, np.array([7.6, 52.0]))]


def write_lines(path: Path, lines: dict[str, list[Point]], **properties: float) -> None:
    """Lines with their roles as GeoJSON; the first has the properties."""
    features = [
        {
            "type": "Feature",
            "properties": {"role": role, **(properties if role == "centreline" else {})},
            "geometry": {"type": "LineString", "coordinates": points},
        }
        for role, points in lines.items()
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}), encoding="utf-8")


def write_kml(path: Path, lines: dict[str, list[Point]]) -> None:
    """Lines with their names as an earth viewer saves them."""
    marks = [
        f"<Placemark><name>{name}</name><LineString><coordinates>"
        f"{' '.join(f'{east},{north},0' for east, north in points)}</coordinates></LineString></Placemark>"
        for name, points in lines.items()
    ]
    path.write_text(f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{"".join(marks)}</Document></kml>')


def write_chart(path: Path) -> None:
    """A cell with a canal 75 m wide and 4 m deep."""
    cell = Cell(path.name)
    for aside in (30.0, -45.0):
        cell.line(CANAL_BANK, at(aside, 100.0))
    starboard, port = at(50.0, 100.0), at(-50.0, 100.0)
    cell.area(DEPTH_AREA, [*starboard, *reversed(port), starboard[0]], "4.0", "5.0")
    cell.save(path)
