"""The track of a voyage on the map: GeoJSON and KML."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

KML = "http://www.opengis.net/kml/2.2"


@dataclass(frozen=True)
class Track:
    """Where a ship was on earth."""

    t: np.ndarray  # (times,) Time [s]
    longitude: np.ndarray  # (times,) WGS84 [deg]
    latitude: np.ndarray  # (times,) WGS84 [deg]
    heading_deg: np.ndarray  # (times,) Where the bow points, clockwise from north [deg]
    name: str  # Of the ship
    summary: str  # How it ended

    def geojson(self) -> str:
        """Give the track as a LineString with its times and headings, and its end as a Point."""
        line = {"type": "LineString", "coordinates": self._points()}
        times = {"t": self.t.round(3).tolist(), "heading_deg": self.heading_deg.round(3).tolist()}
        features = [
            _feature(line, {"name": self.name, "summary": self.summary, **times}),
            _feature({"type": "Point", "coordinates": self._points()[-1]}, {"name": "end", "summary": self.summary}),
        ]
        return json.dumps({"type": "FeatureCollection", "features": features}, indent=1)

    def kml(self) -> str:
        """Give the track as a line and its end as a mark."""
        root = ElementTree.Element("kml", xmlns=KML)
        document = ElementTree.SubElement(root, "Document")
        points = [f"{longitude},{latitude}" for longitude, latitude in self._points()]
        for name, kind, some in ((self.name, "LineString", points), ("end", "Point", points[-1:])):
            placemark = ElementTree.SubElement(document, "Placemark")
            ElementTree.SubElement(placemark, "name").text = name
            ElementTree.SubElement(placemark, "description").text = self.summary
            ElementTree.SubElement(ElementTree.SubElement(placemark, kind), "coordinates").text = " ".join(some)
        ElementTree.indent(root)
        return str(ElementTree.tostring(root, encoding="unicode", xml_declaration=True)) + "\n"

    def _points(self) -> list[list[float]]:
        points: list[list[float]] = np.stack([self.longitude, self.latitude], axis=1).round(9).tolist()
        return points


def _feature(geometry: Mapping[str, object], properties: Mapping[str, object]) -> dict[str, object]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}
