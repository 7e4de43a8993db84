"""Ensembles larger than memory or than one machine: blocks written to Zarr, resumable, on threads or on Dask."""

import hashlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from narrows.errors import InputError, shown
from narrows.progress import bar
from narrows.simulation.grid import Grid
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.store_folder import DONE, checksum, discard, is_done, opened, storing

# Voyages a task, at least: enough that writing and scheduling do not count.
TASK_VESSELS = 100_000


def run_into(path: Path, fleet: KernelRun, grid: Grid, client: Any, progress: bool) -> xr.Dataset:
    """Run what is not yet done of an ensemble, into a Zarr folder, and open it."""
    if client is not None and not hasattr(client, "submit"):
        raise InputError(f"client = {shown(client)} is none; give a dask.distributed.Client")
    blocks = list(grid.blocks(TASK_VESSELS))
    with storing(path), bar(grid.vessels, progress) as advance:
        group = opened(path, _identity(fleet, grid), grid, blocks)
        left = {number for number, block in enumerate(blocks) if not is_done(group, grid.region(block), number)}
        for number in left:
            discard(path, group, grid, number)
        advance(sum(_vessels(grid, block) for number, block in enumerate(blocks) if number not in left))
        tasks = _tasks(path, fleet, grid, blocks, sorted(left))
        for number in _here(tasks) if client is None else _there(client, tasks):
            left.discard(number)
            advance(_vessels(grid, blocks[number]))
        return xr.open_zarr(path, consolidated=False).drop_vars(DONE).assign_attrs(complete=int(not left))


def run_block(path: str, fleet: KernelRun, part: Grid, region: tuple[slice, ...], number: int) -> int:
    """Run one block, write its region, then mark it done; doing it again changes nothing."""
    import zarr

    group = zarr.open_group(path, mode="r+")
    values, shape = part.flat(slice(0, part.sizes[part.axis]))
    columns = fleet.run(values, math.prod(shape))
    for name, column in columns.items():
        group[name][region] = column.reshape(shape)
    group[DONE][number] = checksum(columns)
    return number


Tasks = Iterator[tuple[str, KernelRun, Grid, tuple[slice, ...], int]]


def _tasks(path: Path, fleet: KernelRun, grid: Grid, blocks: list[slice], left: list[int]) -> Tasks:
    for number in left:
        yield str(path.resolve()), fleet, grid.part(blocks[number]), grid.region(blocks[number]), number


def _here(tasks: Tasks) -> Iterator[int]:
    try:
        for task in tasks:
            yield run_block(*task)
    except KeyboardInterrupt:
        return


def _there(client: Any, tasks: Tasks) -> Iterator[int]:
    """Each task carries all it needs, so that a worker's death costs that task and no more."""
    from dask.distributed import as_completed

    futures = [client.submit(run_block, *task, pure=False, retries=3) for task in tasks]
    for future in as_completed(futures):
        yield int(future.result())


def _vessels(grid: Grid, block: slice) -> int:
    return int((block.stop - block.start) * grid.vessels // grid.sizes[grid.axis])


def _identity(fleet: KernelRun, grid: Grid) -> str:
    digest = hashlib.sha256(fleet.text.encode())
    for name, value in sorted(grid.values.items()):
        digest.update(f"{name} {value.dims}".encode())
        digest.update(np.ascontiguousarray(value.to_numpy()).tobytes())
    return digest.hexdigest()
