"""What every benchmark here shares: its sizes, timing by medians, peers that may be absent, the name of the machine."""

import argparse
import importlib.util
import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from rich.console import Console
from rich.table import Table


def sizes(doc: str | None, usual: float, small: float) -> tuple[int, bool]:
    """Read the command line: how many of what the benchmark counts, and whether all is to be small."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("size", nargs="?", type=float, help=f"{usual:g} unless given")
    parser.add_argument("--small", action="store_true", help="sizes that only show that it runs")
    asked = parser.parse_args()
    return int(asked.size or (small if asked.small else usual)), asked.small


def installed(peer: str) -> bool:
    """Whether a peer is there; a line says so where it is not."""
    there = importlib.util.find_spec(peer) is not None
    if not there:
        print(f"{peer} is not installed: left out")
    return there


def median_seconds(work: Callable[[], object], runs: int = 7) -> float:
    """Run once to warm up, then return the median of some runs [s]."""
    work()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def interleaved(works: Mapping[str, Callable[[], object]], rounds: int = 7) -> dict[str, float]:
    """Run each once to warm up, then all in turn for some rounds: medians of process time, of all threads [s]."""
    times: dict[str, list[float]] = {name: [] for name in works}
    for round in range(rounds + 1):
        for name, work in works.items():
            start = time.process_time()
            work()
            if round:
                times[name].append(time.process_time() - start)
    return {name: statistics.median(own) for name, own in times.items()}


def machine() -> str:
    """Name the processor, the cores and Python."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.split(":")[1].strip() for line in lines if "model name" in line]
    return f"{(models or [platform.processor()])[0]}, {os.cpu_count()} cores, Python {platform.python_version()}"


def show(title: str, rows: list[tuple[str, float, str]], unit: str, scale: float) -> None:
    """Print name, time and ratio to the first row, and the machine."""
    table = Table(title=title, caption=machine())
    for header in ("work", unit, "ratio", "note"):
        table.add_column(header, justify="left" if header in ("work", "note") else "right")
    for name, seconds, note in rows:
        table.add_row(name, f"{seconds * scale:.3g}", f"{seconds / rows[0][1]:.2f}", note)
    Console().print(table)
