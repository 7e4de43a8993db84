"""What every benchmark here shares: timing by medians, and the name of the machine."""

import os
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.table import Table


def median_seconds(work: Callable[[], object], runs: int = 7) -> float:
    """Run once to warm up, then return the median of some runs [s]."""
    work()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def machine() -> str:
    """Name the processor, the cores and Python."""
    info = Path("/proc/cpuinfo")
    models = (
        [line.split(":")[1].strip() for line in info.read_text().splitlines() if "model name" in line]
        if (info.exists())
        else [platform.processor()]
    )
    return f"{models[0]}, {os.cpu_count()} cores, Python {platform.python_version()}"


def show(title: str, rows: list[tuple[str, float, str]], unit: str, scale: float) -> None:
    """Print name, time and ratio to the first row, and the machine."""
    table = Table(title=title, caption=machine())
    for header in ("work", unit, "ratio", "note"):
        table.add_column(header, justify="left" if header in ("work", "note") else "right")
    for name, seconds, note in rows:
        table.add_row(name, f"{seconds * scale:.3g}", f"{seconds / rows[0][1]:.2f}", note)
    Console().print(table)
