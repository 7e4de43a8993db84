"""Ensembles larger than memory or than one machine: blocks written to Zarr, resumable, on threads or on Dask."""

import hashlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from narrows.errors import InputError
from narrows.simulation.kernel_run import OUTPUTS, KernelRun
from narrows.simulation.grid import Grid
from narrows.simulation.output_columns import attributes_of, empty_of
from narrows.simulation.progress import bar

TASK_VESSELS = 100_000
"""Voyages a task, at least: enough that writing and scheduling do not count."""
DONE = "block_done"


def run_into(path: Path, fleet: KernelRun, grid: Grid, client: Any, progress: bool) -> xr.Dataset:
    """Run what is not yet done of an ensemble, into a Zarr folder, and open it (ours).

    Parameters
    ----------
    path : Path
        The folder; made where it is absent.
    fleet : KernelRun
        How to run.
    grid : Grid
        What varies.
    client : dask.distributed.Client or None
        Where to run: this machine's threads without one.
    progress : bool
        Show a bar.

    Raises
    ------
    InputError
        Where Zarr is not installed or the folder holds something else.
    """
    blocks = list(grid.blocks(TASK_VESSELS))
    group = _opened(path, fleet, grid, blocks)
    left = [number for number, done in enumerate(group[DONE][:]) if not done]
    tasks = _tasks(path, fleet, grid, blocks, left)
    with bar(grid.vessels, progress) as advance:
        advance(sum(_vessels(grid, block) for i, block in enumerate(blocks) if i not in left))
        for number in _here(tasks) if client is None else _there(client, tasks):
            advance(_vessels(grid, blocks[number]))
    found = xr.open_zarr(path, consolidated=False)
    return found.drop_vars(DONE).assign_attrs(complete=int(bool(found[DONE].all())))


def run_block(path: str, fleet: KernelRun, part: Grid, region: tuple[slice, ...], number: int) -> int:
    """Run one block, write its region, then mark it done; doing it again changes nothing (ours).

    Parameters
    ----------
    path : str
        The Zarr folder.
    fleet : KernelRun
        How to run.
    part : Grid
        What varies in this block.
    region : tuple of slice
        Where the block lies among all vessels.
    number : int
        Of the block.

    Returns
    -------
    int
        The number of the block.
    """
    import zarr

    group = zarr.open_group(path, mode="r+")
    values, shape = part.flat(slice(0, part.sizes[part.axis]))
    for name, column in fleet.run(values, math.prod(shape)).items():
        group[name][region] = column.reshape(shape)
    group[DONE][number] = True
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


def _opened(path: Path, fleet: KernelRun, grid: Grid, blocks: list[slice]) -> Any:
    try:
        import zarr
    except ImportError:
        raise InputError("a store needs Zarr: pip install 'narrows[cluster]'") from None
    identity = _identity(fleet, grid)
    if path.exists():
        group = zarr.open_group(str(path), mode="r+")
        if group.attrs.get("identity") != identity:
            raise InputError(f"{path}: holds another ensemble; choose another folder or remove it")
        return group
    xr.Dataset(coords=grid.coordinates()).to_zarr(path, mode="w", consolidated=False)
    group = zarr.open_group(str(path), mode="r+")
    _make_columns(group, grid, blocks)
    group.attrs["identity"] = identity
    return group


def _make_columns(group: Any, grid: Grid, blocks: list[slice]) -> None:
    shape = tuple(grid.sizes.values())
    chunks = tuple(blocks[0].stop if name == grid.axis else n for name, n in grid.sizes.items())
    for name, kind in OUTPUTS.items():
        group.create_array(
            name, shape=shape, chunks=chunks, dtype=np.dtype(kind), fill_value=empty_of(kind),
            dimension_names=list(grid.sizes), attributes=attributes_of(name),
        )  # fmt: skip
    group.create_array(DONE, shape=(len(blocks),), chunks=(1,), dtype="bool", dimension_names=["block"])


def _identity(fleet: KernelRun, grid: Grid) -> str:
    digest = hashlib.sha256(fleet.text.encode())
    for name, value in sorted(grid.values.items()):
        digest.update(f"{name} {value.dims}".encode())
        digest.update(np.ascontiguousarray(value.to_numpy()).tobytes())
    return digest.hexdigest()
