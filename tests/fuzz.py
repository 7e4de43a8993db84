"""A fuzzer of every door: files of models and ships, tables, the command line, the arguments of functions.

    python tests/fuzz.py 1000000 [--seed 0] [--door name]

Whatever comes in, what comes out is an answer or an ``InputError`` of one line, and on the command line exit code 0, 1
or 2. Anything else is a finding: it is printed with the number that makes it again, and the exit code is 1.
"""

import argparse
import contextlib
import copy
import io
import math
import os
import random
import string
import sys
import tempfile
import time
import tomllib
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
import xarray as xr

import narrows as nw
from engine_models import steered
from narrows.base.errors import InputError
from tables import DTC_SHIP, frame_of, short_twin


def held_ship() -> nw.Model:
    """A steered ship that is known to a tenth."""
    model = steered().with_coefficients(b_bank=0.3, c_bank=0.04)
    return replace(model, covariance=np.diag([(0.1 * model[name]) ** 2 for name in model.terms.names]))


MEMORY = "/dev/shm"
"""Where files cost no disk, on systems that have it."""
SLOW = 120.0
"""An answer that takes longer [s] is a finding too; the first of an ensemble compiles."""
DTC, KVLCC2 = nw.published("mikkelsen2025_dtc"), nw.published("yasukawa2015_kvlcc2")
PUBLISHED = Path(nw.__file__).parent / "model" / "published"
TESTS = short_twin()
HELD = held_ship()
FRAME = frame_of(TESTS).iloc[:40:4]
CSV = FRAME.to_csv(index=False)
DIALECTS = (
    CSV.encode(), FRAME.to_csv(index=False, sep=";", decimal=",").encode("utf-8-sig"),
    FRAME.to_csv(index=False, sep="\t", decimal=",").encode("utf-16"), CSV.replace("\n", "\n# remark\n", 4).encode(),
    ("lab\n\n" + CSV.replace("\n", "\n" + "m,rad;".join(",," for _ in range(7)) + "\n", 1)).encode(),
    CSV.replace(",", " ").encode(), b"# " + CSV.encode(),
)  # fmt: skip
CONDITIONS = (
    "wind windage wind_change rudder_zero_deg y_zero yaw_rate_deg sway_change leg_time y_error rudder_error_deg"
)
LEGS = "leg,y [m],u [kn],rudder [deg],drift [deg],y_error\na,0.5,1.6,3.0,1.0,0.1\nb,-0.5,1.6,-3.0,-1.0,0.1\n"
MAPPING = {"columns": {"y": "y", "X": "x", "x": "X", "N": ""}, "units": {"psi": "rad"}, "positive": {"y": "port"}}

NUMBERS = (
    0, 1, -1, 2, 3, 7, 10**18, 2**63, 2**64, 10**400, -(10**400), 0.0, -0.0, 0.5, -0.5, 1.5, 100.0, 1e-300, 5e-324,
    1e-9, 1e9, 1e20, 1e154, 1e200, 1e308, -1e308, math.inf, -math.inf, math.nan, True, False,
)  # fmt: skip
WORDS = (
    "", " ", "a", "nan", "inf", "1", "-1", "1e400", "0x10", "1_000", "1,2", "a\nb", "\x1b[31m", "é", "\u2028",
    "\U0001f6a2", "paper", "mixed+keel_gap", "mmg", "mmg+delta", "none", "corners", "free", "__debug__", "__class__",
    "lambda", "../x", "/dev/null", "a" * 5000, "1" * 400, "9" * 5000, "{0}", "%s", "None", "test", "u", "b_v", "X",
)  # fmt: skip


UNITS = ("deg", "rad", "m", "mm", "kN", "1", "", "((", "m/s2", "°", "x" * 99)
CHOICES = "surge surge_inertia coriolis contact waterway controller"
STARTS = f"y u duration dt x psi v r X Y N rudder {CHOICES}"
VARIED = "beam width depth draft density length heave b_rdot c_vdot b_v nonsense block_coefficient mass"


def nested(depth: int) -> list[Any]:
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


def plain(chance: random.Random, deep: int = 2) -> Any:
    """A value as TOML holds it, likelier a number."""
    kind = chance.random()
    if kind < 0.55:
        return chance.choice(NUMBERS)
    if kind < 0.75:
        return chance.choice(WORDS)
    if kind < 0.8:
        return nested(chance.choice([3, 40, 300]))
    if deep == 0:
        return []
    if kind < 0.92:
        return [plain(chance, deep - 1) for _ in range(chance.randrange(4))]
    return {chance.choice(WORDS): plain(chance, deep - 1) for _ in range(chance.randrange(3))}


def anything(chance: random.Random) -> Any:
    """A value as a caller may give it."""
    value = plain(chance)
    kind = chance.randrange(16)
    made: dict[int, Callable[[], Any]] = {
        0: lambda: None,
        1: lambda: 1j,
        2: lambda: object(),
        3: lambda: np.array(chance.choice([1.0, 1j, "a", math.nan, True])),
        4: lambda: np.array([chance.uniform(-3, 3) for _ in range(chance.randrange(4))]),
        5: lambda: xr.DataArray(
            [chance.choice([0.0, 1.0, math.nan, 1e308]) for _ in range(2)], dims=chance.choice("abu")
        ),
        6: lambda: xr.DataArray([0.1, 0.2], dims="a", coords={"a": chance.choice([[1, 2], ["x", "y"], [1, 1]])}),
        7: lambda: np.datetime64("2020-01-01"),
        8: lambda: b"bytes",
        9: lambda: (chance.choice(NUMBERS) for _ in range(2)),
        10: lambda: np.float32(chance.uniform(-2, 2)),
    }
    return made.get(kind, lambda: value)()


def bytes_of(content: bytes, chance: random.Random) -> bytes:
    """A file with a few bytes wrong, cut, doubled or moved."""
    data = bytearray(content)
    for _ in range(chance.choice([1, 1, 2, 5, 30])):
        at = chance.randrange(len(data) + 1)
        kind = chance.randrange(7)
        if kind == 0:
            data[at : at + 1] = bytes([chance.randrange(256)])
        elif kind == 1:
            data[at:at] = chance.choice(
                [b"[", b"]", b'"', b"'", b",", b"\n", b"\r", b"=", b"\0", b"#", b".", b"-", b"e9"]
            )
        elif kind == 2:
            del data[at : at + chance.choice([1, 1, 3, 50])]
        elif kind == 3:
            del data[at:]
        elif kind == 4:
            data[at:at] = data[at : at + chance.choice([1, 10, 100])]
        elif kind == 5:
            data[at:at] = str(chance.choice(WORDS)).encode("utf-8", "replace")
        else:
            data[at:at] = b"[" * chance.choice([10, 1000, 100_000]) if chance.random() < 0.02 else b"9" * 5
    return bytes(data)


def struck(tables: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """Tables of a TOML file with a few values, keys or sections wrong."""
    tables = copy.deepcopy(tables)
    for _ in range(chance.choice([1, 1, 1, 2, 4])):
        place: Any = tables
        while isinstance(place, dict) and place and chance.random() < 0.8:
            key = chance.choice(list(place))
            if not isinstance(place[key], dict | list) or not place[key]:
                break
            place = place[key]
        if isinstance(place, dict):
            key = chance.choice([*place, chance.choice(WORDS)]) if place else chance.choice(WORDS)
            if chance.random() < 0.25:
                place.pop(key, None)
            else:
                place[key] = plain(chance)
        elif place:
            place[chance.randrange(len(place))] = plain(chance)
    return tables


def dumped(tables: dict[str, Any]) -> bytes:
    try:
        return tomli_w.dumps(tables).encode("utf-8")
    except (ValueError, TypeError, RecursionError):
        return b"x = 1"


def given(names: str, chance: random.Random) -> dict[str, Any]:
    """A few arguments that may be anything."""
    return {name: anything(chance) for name in chance.sample(names.split(), chance.choice([1, 1, 2, 3]))}


class Doors:
    """Every way in, each with something wrong.

    Parameters
    ----------
    folder : Path
        For files.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        fitted = nw.identify(TESTS).model
        nw.save_model(fitted, folder / "fitted.toml")
        nw.save_model(DTC, folder / "good.toml")
        self.models = [
            (folder / "fitted.toml").read_bytes(),
            *(p.read_bytes() for p in sorted(PUBLISHED.glob("*.toml"))),
        ]
        every = {
            "ship": tomllib.loads(DTC_SHIP)["ship"], "canal": {"width": 7.0}, "depths": {"A": 0.3, "B": 0.4},
            "steering": {"rate_deg": 3.0}, "water": {"density": 998.0},
            "propeller": vars(KVLCC2.configuration.propeller), "rudder": vars(KVLCC2.configuration.rudder),
        }  # fmt: skip
        self.ships = [DTC_SHIP.encode(), dumped(every)]
        (folder / "ship.toml").write_bytes(self.ships[0])
        (folder / "good.csv").write_text(CSV)
        frame = frame_of(TESTS).iloc[:40:4]
        with contextlib.suppress(ImportError):
            frame.to_parquet(folder / "good.parquet", index=False)
        self.parquet = (folder / "good.parquet").read_bytes() if (folder / "good.parquet").exists() else b"PAR1"
        with contextlib.suppress(ImportError):
            frame.to_excel(folder / "good.xlsx", index=False)
        self.xlsx = (folder / "good.xlsx").read_bytes() if (folder / "good.xlsx").exists() else b"PK"
        self.dat = (
            b"\t".join(b"%s" % name.encode() for name in frame) + b"\n" + b"\t" * 14 + b"\n" + b"1\t" * 15 + b"\n"
        )

    def _file(self, name: str, content: bytes) -> Path:
        path = self.folder / name
        path.write_bytes(content)
        return path

    def model_bytes(self, chance: random.Random) -> None:
        nw.load_model(self._file("m.toml", bytes_of(chance.choice(self.models), chance)))

    def model_tables(self, chance: random.Random) -> None:
        tables = tomllib.loads(chance.choice(self.models[1:]).decode())
        if chance.random() < 0.1:
            tables = tomllib.loads(self.models[0].decode())
        model = nw.load_model(self._file("m.toml", dumped(struck(tables, chance))))
        if chance.random() < 0.02:
            nw.simulate(model, 0.1, duration=0.1, contact=chance.choice(["corners", "midship", "none"]))

    def ship_bytes(self, chance: random.Random) -> None:
        nw.read_ship(self._file("s.toml", bytes_of(chance.choice(self.ships), chance)))

    def ship_tables(self, chance: random.Random) -> None:
        nw.read_ship(self._file("s.toml", dumped(struck(tomllib.loads(chance.choice(self.ships).decode()), chance))))

    def csv_bytes(self, chance: random.Random) -> None:
        self._read(self._file("t.csv", bytes_of(chance.choice(DIALECTS), chance)), chance)

    def mappings(self, chance: random.Random) -> None:
        path = self._file("c.toml", dumped(struck(MAPPING, chance)))
        self._read(self._file("t.csv", chance.choice(DIALECTS)), chance, path)

    def csv_cells(self, chance: random.Random) -> None:
        rows = [line.split(",") for line in CSV.splitlines()]
        for _ in range(chance.choice([1, 1, 2, 5])):
            row = chance.choice(rows[:1] if chance.random() < 0.3 else rows)
            at, kind = chance.randrange(len(row)), chance.randrange(5)
            cell = str(chance.choice(WORDS) if chance.random() < 0.5 else _spelled(chance.choice(NUMBERS)))
            if kind == 0:
                row.insert(at, cell)
            elif kind == 1 and len(row) > 1:
                del row[at]
            elif kind == 2:
                row[at] = f"{row[at]} [{chance.choice(UNITS)}]"
            elif kind == 3:
                row.extend([cell] * chance.choice([1, 3]))
            else:
                row[at] = cell
        self._read(self._file("t.csv", "\n".join(map(",".join, rows)).encode("utf-8", "replace")), chance)

    def other_tables(self, chance: random.Random) -> None:
        suffix = chance.choice([".parquet", ".dat", ".xlsx"])
        content = {".parquet": self.parquet, ".dat": self.dat, ".xlsx": self.xlsx}[suffix]
        self._read(self._file(f"t{suffix}", bytes_of(content, chance)), chance)

    def _read(self, path: Path, chance: random.Random, mapping: Path | None = None) -> None:
        where = None
        if chance.random() < 0.1:
            where = chance.choice(
                [
                    "u > 0.3",
                    "u",
                    "u >",
                    "(" * 500,
                    "-" * 5000 + "u",
                    "@x",
                    "test == 'yaw'",
                    "",
                    "y.no",
                    "u > 1j",
                    "psi_deg > 1",
                    "u_deg > 1",
                    "r_degps > 1 and u > 0",
                    "rudder > 0",
                    "psi_deg",
                    "condition == 3",
                ]
            )
        if chance.random() < 0.2 and path.suffix in (".csv", ".parquet"):
            for _ in nw.stream_captive(path, TESTS.configuration, where=where, mapping=mapping).blocks():
                pass
            return
        tests = nw.read_captive(path, TESTS.configuration, where=where, mapping=mapping)
        if chance.random() < 0.05:
            nw.identify(tests)

    def simulate(self, chance: random.Random) -> None:
        nw.simulate(chance.choice([DTC, DTC, KVLCC2]), **{"duration": 0.05, **given(f"{STARTS} at", chance)})

    def ensemble(self, chance: random.Random) -> None:
        more = "samples seed workers"
        nw.ensemble(DTC, **{"duration": 0.05, **given(f"{STARTS} {VARIED} {more}", chance)})

    def identify(self, chance: random.Random) -> None:
        names = ["terms", "balance", "accelerations", "pool"]
        nw.identify(TESTS, **{name: anything(chance) for name in chance.sample(names, chance.choice([1, 2]))})

    def scale(self, chance: random.Random) -> None:
        names = ["density", "width", "depth", "length"]
        given = {"length": 100.0, **{name: anything(chance) for name in chance.sample(names, chance.choice([1, 2]))}}
        nw.scale_model(chance.choice([DTC, KVLCC2]), **given)

    def particulars(self, chance: random.Random) -> None:
        part = chance.choice([nw.Ship, nw.Canal, nw.Water, nw.Propeller, nw.Rudder, nw.SteeringGear])
        own = {
            nw.Ship: DTC.configuration.ship, nw.Canal: nw.Canal(7.0), nw.Water: nw.Water(),
            nw.SteeringGear: nw.SteeringGear(), nw.Propeller: KVLCC2.configuration.propeller,
            nw.Rudder: KVLCC2.configuration.rudder,
        }[part]  # fmt: skip
        made = part(**{**vars(own), chance.choice(list(vars(own))): anything(chance)})
        if part is nw.Ship:
            nw.Configuration(made, nw.Canal(7.0, 1.0)).values()

    def legs(self, chance: random.Random) -> None:
        told: dict[str, Any] = {}
        if chance.random() < 0.3:
            told["conditions"] = nw.SteadyConditions(**given(CONDITIONS, chance))
        kind = chance.randrange(4)
        if kind == 0:
            asked = given("offsets speeds legs targets", chance)
            nw.plan_steady(HELD, **asked, **told)
        elif kind == 1:
            nw.learn_steady(HELD, self._file("h.csv", bytes_of(LEGS.encode(), chance)), **told)
        else:
            columns = {"y": [0.5, -0.5], "u": [0.8, 0.8], "rudder": [0.05, -0.05], "drift": [0.02, -0.02]}
            nw.learn_steady(HELD, struck(columns, chance), **told)

    def terms(self, chance: random.Random) -> None:
        name = (
            chance.choice(WORDS)
            if chance.random() < 0.6
            else "".join(chance.choices(string.printable, k=chance.randrange(9)))
        )
        row = nw.PAPER.sway[0]
        nw.Term(name, row.symbol, row.regressor, row.dimension)
        if chance.random() < 0.5:
            DTC.with_coefficients(**{chance.choice([*DTC.coefficients, name]): anything(chance)})

    def command_line(self, chance: random.Random) -> None:
        base = chance.choice(self._commands())
        words = list(base)
        for _ in range(chance.choice([1, 1, 2, 4])):
            at, kind = chance.randrange(len(words) + 1), chance.randrange(5)
            word = chance.choice(
                [*WORDS, *map(_spelled, NUMBERS), "--json", "--help", "-o", "--y", "--u", "--samples", "--plot"]
            )
            if kind == 0:
                words.insert(at, word)
            elif kind == 1 and words:
                del words[min(at, len(words) - 1)]
            elif words:
                words[min(at, len(words) - 1)] = word
        code, error = command(words)
        assert code in (0, 1, 2), f"{words}: exit code {code}"
        assert "Traceback" not in error, f"{words}: {error}"
        assert code != 2 or error.startswith("narrows: "), f"{words}: {error!r}"
        assert code != 2 or error.count("\n") == 1, f"{words}: {error!r}"

    def _commands(self) -> list[list[str]]:
        where = str(self.folder)
        return [
            [
                "simulate",
                f"{where}/good.toml",
                "--y",
                "0.5",
                "--speed",
                "1",
                "--duration",
                "0.1",
                "--dt",
                "0.05",
                "--json",
            ],
            [
                "simulate",
                "yasukawa2015_kvlcc2",
                "--contact",
                "none",
                "--speed",
                "7kn",
                "--duration",
                "0.1",
            ],
            ["map", "mikkelsen2025_dtc", "--y", "0:1:3", "--speed", "1", "--duration", "0.1", "--dt", "0.05", "--json"],
            [
                "map",
                f"{where}/fitted.toml",
                "--y",
                "0,1",
                "--samples",
                "3",
                "--within",
                "5",
                "--duration",
                "0.1",
                "-o",
                f"{where}/o.nc",
            ],
            ["scale", "mikkelsen2025_dtc", "--length", "355", "--width", "600", "-o", f"{where}/full.toml"],
            [
                "identify",
                f"{where}/good.csv",
                "--ship",
                f"{where}/ship.toml",
                "--where",
                "u > 0",
                "--terms",
                "paper",
                "--json",
            ],
            ["explain", f"{where}/good.toml", f"{where}/good.csv", "--compare", "paper", "--json"],
        ]


def _spelled(value: Any) -> str:
    try:
        return str(value)
    except ValueError:
        return "9" * 5000


def command(words: list[str]) -> tuple[int, str]:
    """Run the command line in this process: exit code and stderr."""
    from narrows.cli import main

    out, error = io.StringIO(), io.StringIO()
    before = sys.argv
    sys.argv = ["narrows", *words]
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            main()
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else 0, error.getvalue()
    finally:
        sys.argv = before
    return 0, error.getvalue()


SHARES = {
    "model_bytes": 14, "model_tables": 16, "ship_bytes": 14, "ship_tables": 14, "csv_bytes": 5, "csv_cells": 4,
    "mappings": 2, "other_tables": 2, "simulate": 5, "ensemble": 6, "identify": 1, "scale": 4, "particulars": 5,
    "legs": 3, "terms": 2, "command_line": 1,
}  # fmt: skip
"""How often each door is tried, of a hundred: the dear ones less."""


def fuzz(count: int, seed: int, only: str = "") -> dict[str, str]:
    """Try so many inputs and return what was found, one of each kind, by the place in the code.

    Parameters
    ----------
    count : int
        Of inputs.
    seed : int
        Of the first; the next has the next.
    only : str
        One door alone.
    """
    found: dict[str, str] = {}
    tried: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(dir=MEMORY if os.path.isdir(MEMORY) else None) as place, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        doors, home = Doors(Path(place)), Path.cwd()
        os.chdir(place)  # Words on the command line may name files.
        try:
            for number in range(seed, seed + count):
                chance = random.Random(number)
                door = only or chance.choices(list(SHARES), list(SHARES.values()))[0]
                tried[door] += 1
                if number % 10_000 == 0:
                    print(f"--seed {number}", file=sys.stderr, flush=True)
                try_one(doors, door, number, chance, found)
        finally:
            os.chdir(home)
    print(dict(tried), file=sys.stderr)
    return found


def try_one(doors: Doors, door: str, number: int, chance: random.Random, found: dict[str, str]) -> None:
    """Try one input; note what it finds."""
    start = time.perf_counter()
    try:
        getattr(doors, door)(chance)
    except InputError as error:
        if len(str(error).splitlines()) != 1 or len(str(error)) > 2000:
            note(found, f"{door}: not one line", number, str(error))
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        last = traceback.extract_tb(error.__traceback__)
        ours = [frame for frame in last if "narrows" in frame.filename and "fuzz" not in frame.filename] or last
        where = f"{door}: {type(error).__name__} at {Path(ours[-1].filename).name}:{ours[-1].lineno}"
        note(found, where, number, str(error)[:300] if not isinstance(error, AssertionError) else str(error)[:600])
    if time.perf_counter() - start > SLOW:
        note(found, f"{door}: takes {time.perf_counter() - start:.0f} s", number, "")


def note(found: dict[str, str], kind: str, number: int, said: str) -> None:
    """Keep one of each kind, and say it at once."""
    if kind not in found:
        found[kind] = f"--seed {number}: {said}"
        print(f"{kind} (--seed {number})\n    {said!r}", flush=True)


def main() -> None:
    """Run as a script."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, help="inputs to try")
    parser.add_argument("--seed", type=int, default=0, help="of the first")
    parser.add_argument("--door", default="", help=f"one alone: {', '.join(SHARES)}")
    given = parser.parse_args()
    start = time.perf_counter()
    found = fuzz(given.count, given.seed, given.door)
    print(f"{given.count} inputs, {len(found)} findings, {time.perf_counter() - start:.0f} s")
    raise SystemExit(bool(found))


if __name__ == "__main__":
    main()
