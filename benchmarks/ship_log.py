"""A year of a ship's log, a row a second, from Parquet to records along its own times, and through the checks.

    python benchmarks/ship_log.py [ROWS] [--small]

The peer is pandas alone, which reads the same file whole. Memory is the most that the process had until then.
"""

import resource
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from common import median_seconds, show, sizes

import narrows as nw

PIECE = 200_000
A_DAY, BETWEEN = 20_000, 4_000.0
"""Rows of a record, and time between two [s]."""


def pieces(rows: int) -> Iterator[pa.Table]:
    """Records of a ship that goes to and fro about its line at 8 knots."""
    for first in range(0, rows, PIECE):
        second = np.arange(first, min(first + PIECE, rows), dtype=float)
        t = second + np.floor(second / A_DAY) * BETWEEN
        yield pa.table({
            "t": t, "x": 4.1 * (second % A_DAY), "y": 3.0 * np.sin(t / 200), "psi": 0.02 * np.cos(t / 200),
            "r [deg/s]": np.degrees(-0.0001 * np.sin(t / 200)), "rudder [deg]": np.round(3 * np.sin(t / 200)),
            "u [kn]": np.full(len(t), 8.0),
        })  # fmt: skip


def written(rows: int, path: Path) -> Path:
    """Write the log."""
    tables = pieces(rows)
    first = next(tables)
    with pq.ParquetWriter(path, first.schema) as writer:
        writer.write_table(first)
        for table in tables:
            writer.write_table(table)
    return path


def main(rows: int, runs: int) -> None:
    """Measure and print."""
    model = nw.scale_model(nw.published("yasukawa2015_kvlcc2"), 320.0).model
    with tempfile.TemporaryDirectory() as folder:
        path = written(rows, Path(folder, "year.parquet"))
        work: dict[str, Callable[[], object]] = {
            "stream_log": lambda: sum(1 for _ in nw.stream_log(path)),
            "stream_log and check_log": lambda: len(nw.check_log(nw.stream_log(path), model)),
            "pandas alone, whole": lambda: len(pq.read_table(path).to_pandas()),
        }
        measured = []
        for name, act in work.items():
            seconds = median_seconds(act, runs)
            most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
            measured.append((name, seconds, f"{most:.0f} MB"))
    show(f"a log of {rows:.2g} rows", measured, "s", 1)


if __name__ == "__main__":
    size, small = sizes(__doc__, usual=3e7, small=50_000)
    main(size, runs=1)
