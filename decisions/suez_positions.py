"""What positions some twelve minutes apart, without heading, cannot give: Suez, March 2021, heard by the monitor.

The positions of 256 ships, 20 to 24 March 2021 (VesselsValue, by movingpandas-examples), and a centreline of 14 points
(gabrielfuenmar/suez-canal-transits, MIT) are not of this project; the folder has ``boat-positions.csv`` and
``suez_routes.geojson``. The canal is taken for 205 m wide, the ship for the KCS at 400 m.

python decisions/suez_positions.py FOLDER [SHIP]
"""

import csv
import json
import sys
from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from narrows.identification.fitting import bundled_ship
from narrows.model.tables import table_named
from narrows.readers.nmea import DecodedMessage, Entry
from narrows.warning.inputs.bridge_readings import by_second
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.waterway import Bank, Centreline, Waterway
from narrows.waterway.map_lines import projected

LENGTH, WIDTH, DEPTH = 399.94, 205.0, 24.0
EVER_GIVEN, TRACK = "235", "Suez Passage track"


def canal(folder: Path) -> Waterway:
    """Along the coarse line."""
    routes = json.loads((folder / "suez_routes.geojson").read_text())["features"]
    (points,) = (route["geometry"]["coordinates"] for route in routes if route["properties"]["name"] == TRACK)
    degrees = np.array(points, float)[:, :2]
    line = Centreline(projected(degrees, degrees[0]))
    ends, half = np.array([0.0, line.length]), np.full(2, WIDTH / 2)
    sides = Bank("starboard", ends, half), Bank("port", ends, half)
    return Waterway(line, *sides, (ends, np.full(2, DEPTH)), name="Suez", origin=tuple(degrees[0].tolist()))


def positions(folder: Path, ship: str) -> Iterator[Entry]:
    """Of one ship, as they were told."""
    with (folder / "boat-positions.csv").open(encoding="utf-8-sig") as file:
        for row in csv.DictReader(file):
            if row["ID"] == ship:
                at = datetime.strptime(row["ais_pos_timestamp"], "%d/%m/%Y %H:%M").replace(tzinfo=UTC)
                place = {name: float(row[name]) for name in ("longitude", "latitude")}
                yield Entry(at.timestamp(), DecodedMessage({"position": place}, "AIVDM"))


def main(folder: Path, ship: str) -> None:
    """Watch it, and count what could be said."""
    model = bundled_ship(LENGTH, WIDTH, DEPTH, table_named("speed+helm"))
    watched, words, alerts = BridgeMonitor(model, canal(folder), members=20), Counter[str](), Counter[str]()
    told = sorted(positions(folder, ship), key=lambda entry: entry.t)
    for tick in by_second(told):
        status = watched.update(tick, tick.t)
        words[status.word] += 1
        alerts.update(f"{alert.priority.words}: {alert.text.split(' for ')[0]}" for alert in status.changed)
    gap = np.median(np.diff([entry.t for entry in told])) / 60
    print(f"{len(told)} positions, {gap:.0f} min apart (median); seconds heard, by what could be said: {dict(words)}")
    print("alerts that changed, by what they say:", dict(alerts.most_common(4)))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else EVER_GIVEN)
