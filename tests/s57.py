"""Writes cells of an electronic chart (S-57 over ISO 8211), as small as a test needs."""

import struct
from pathlib import Path

UNIT, FIELD = b"\x1f", b"\x1e"
SCALE = 10_000_000
"""Coordinates are whole numbers of its inverse [deg]."""
COASTLINE, SHORE_AREA, CANAL_BANK, DEPTH_AREA, INLAND_DEPTH_AREA = 30, 122, 17002, 42, 17003
LEAST_DEPTH, MOST_DEPTH = 87, 88
LINE, AREA = 2, 3
NODE, EDGE, FEATURE = 120, 130, 100
FIELDS = (
    ("0000", "0000;&   ", "", ""),
    ("0001", "0500;&   ", "", "(b12)"),
    ("DSID", "1600;&   ", "RCNM!RCID!EXPP!INTU!DSNM!EDTN!UPDN!UADT!ISDT!STED!PRSP!PSDN!PRED!PROF!AGEN!COMT",
     "(b11,b14,2b11,3A,2A(8),R(4),b11,2A,b11,b12,A)"),
    ("DSSI", "1600;&   ", "DSTR!AALL!NALL!NOMR!NOCR!NOGR!NOLR!NOIN!NOCN!NOED!NOFA", "(3b11,8b14)"),
    ("DSPM", "1600;&   ", "RCNM!RCID!HDAT!VDAT!SDAT!CSCL!DUNI!HUNI!PUNI!COUN!COMF!SOMF!COMT",
     "(b11,b14,3b11,b14,4b11,2b14,A)"),
    ("FRID", "1600;&   ", "RCNM!RCID!PRIM!GRUP!OBJL!RVER!RUIN", "(b11,b14,2b11,2b12,b11)"),
    ("FOID", "1600;&   ", "AGEN!FIDN!FIDS", "(b12,b14,b12)"),
    ("ATTF", "2600;&   ", "*ATTL!ATVL", "(b12,A)"),
    ("FSPT", "2600;&   ", "*NAME!ORNT!USAG!MASK", "(B(40),3b11)"),
    ("VRID", "1600;&   ", "RCNM!RCID!RVER!RUIN", "(b11,b14,b12,b11)"),
    ("VRPT", "2600;&   ", "*NAME!ORNT!USAG!TOPI!MASK", "(B(40),4b11)"),
    ("SG2D", "2500;&   ", "*YCOO!XCOO", "(2b24)"),
)  # fmt: skip
"""Of the format: tag, controls, labels, types."""
PARENTS = "0001DSIDDSIDDSSI0001DSPM0001FRIDFRIDFOIDFRIDATTFFRIDFSPT0001VRIDVRIDVRPTVRIDSG2D"

Point = tuple[float, float]


def record(fields: list[tuple[str, bytes]], first: bool = False) -> bytes:
    directory, place = b"", 0
    for tag, content in fields:
        directory += tag.encode() + b"%06d%06d" % (len(content), place)
        place += len(content)
    base = 24 + len(directory) + 1
    leader = (b"3LE1 09", b" ! ") if first else (b" D     ", b"   ")
    head = b"%05d" % (base + place) + leader[0] + b"%05d" % base + leader[1] + b"6604"
    return head + directory + FIELD + b"".join(content for _, content in fields)


def description() -> bytes:
    fields = []
    for tag, controls, labels, types in FIELDS:
        rest = PARENTS.encode() if tag == "0000" else tag.encode() + UNIT + labels.encode() + UNIT + types.encode()
        fields.append((tag, controls.encode() + (UNIT if tag == "0000" else b"") + rest + FIELD))
    return record(fields, first=True)


class Cell:
    """A base cell; lines and areas of longitude and latitude go in one by one."""

    def __init__(self, name: str, depth_unit: int = 1) -> None:
        self.records, self.used = [description()], dict.fromkeys((NODE, EDGE, FEATURE), 0)
        words = UNIT.join(word.encode() for word in (name, "1", "0")) + UNIT
        identity = struct.pack("<BIBB", 10, 1, 1, 6) + words + b"2024010120240101" + b"03.1"
        identity += b"\x01" + UNIT + b"2.0" + UNIT + struct.pack("<BH", 1, 540) + UNIT
        self._add([("DSID", identity), ("DSSI", struct.pack("<3B8I", 2, 1, 0, *[0] * 8))])
        parameters = struct.pack("<BI3BI4B2I", 20, 1, 2, 23, 23, 5000, depth_unit, 1, 1, 1, SCALE, 10)
        self._add([("DSPM", parameters + UNIT)])

    def line(self, kind: int, points: list[Point], **attributes: str) -> None:
        self._feature(kind, LINE, self._edge(points), attributes)

    def area(self, kind: int, points: list[Point], least: str = "", most: str = "", hole: list[Point] = ()) -> None:
        depths = {LEAST_DEPTH: least, MOST_DEPTH: most}
        inner = [self._edge(hole)] if hole else []
        self._feature(kind, AREA, self._edge(points), depths if least else {}, inner)

    def save(self, path: Path) -> Path:
        path.write_bytes(b"".join(self.records))
        return path

    def _add(self, fields: list[tuple[str, bytes]]) -> None:
        number = struct.pack("<H", len(self.records)) + FIELD
        self.records.append(record([("0001", number), *((tag, content + FIELD) for tag, content in fields)]))

    def _vector(self, kind: int, *fields: tuple[str, bytes]) -> bytes:
        self.used[kind] += 1
        self._add([("VRID", struct.pack("<BIHB", kind, self.used[kind], 1, 1)), *fields])
        return struct.pack("<BI", kind, self.used[kind])

    def _edge(self, points: list[Point]) -> bytes:
        start = self._vector(NODE, ("SG2D", packed(points[:1])))
        stop = start if points[0] == points[-1] else self._vector(NODE, ("SG2D", packed(points[-1:])))
        ends = b"".join(node + bytes([255, 255, which, 255]) for node, which in ((start, 1), (stop, 2)))
        inner = [("SG2D", packed(points[1:-1]))] if len(points) > 2 else []
        return self._vector(EDGE, ("VRPT", ends), *inner)

    def _feature(self, kind: int, shape: int, edge: bytes, attributes: dict, inner: list[bytes] = ()) -> None:
        self.used[FEATURE] += 1
        number = self.used[FEATURE]
        said = b"".join(struct.pack("<H", code) + text.encode() + UNIT for code, text in attributes.items())
        fields = [("FRID", struct.pack("<BIBBHHB", FEATURE, number, shape, 2, kind, 1, 1))]
        fields += [("FOID", struct.pack("<HIH", 540, number, 1))] + ([("ATTF", said)] if said else [])
        pointers = edge + bytes([1, 1 if shape == AREA else 255, 255])
        pointers += b"".join(ring + bytes([1, 2, 255]) for ring in inner)
        self._add([*fields, ("FSPT", pointers)])


def packed(points: list[Point]) -> bytes:
    return b"".join(struct.pack("<ii", round(lat * SCALE), round(lon * SCALE)) for lon, lat in points)
