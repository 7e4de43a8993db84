"""Ensembles larger than memory or one machine: blocks in Zarr, resumable, on threads or on Dask."""

import hashlib
import math
import os
import shutil
from collections.abc import Iterator
from contextlib import suppress
from itertools import starmap
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import xarray as xr

from narrows.base.errors import InputError, needs, reason, shown
from narrows.base.progress import bar
from narrows.simulation.grid import Grid
from narrows.simulation.kernel_run import OUTPUTS, KernelRun
from narrows.simulation.outcome import KINDS, WAYS
from narrows.simulation.settings import TASK_VESSELS


def run_into(path: Path, fleet: KernelRun, grid: Grid, client: Any, progress: bool) -> xr.Dataset:
    """Run the missing blocks of an ensemble into a Zarr folder, and open it."""
    if client is not None and not hasattr(client, "submit"):
        raise InputError(f"client = {shown(client)} is none; give a dask.distributed.Client")
    blocks = list(grid.blocks(TASK_VESSELS))
    identity = hashlib.sha256(f"{fleet.text} {TASK_VESSELS}".encode())
    for name, value in sorted(grid.values.items()):
        identity.update(f"{name} {value.dims}".encode())
        identity.update(np.ascontiguousarray(value.to_numpy()).tobytes())
    sizes = [(block.stop - block.start) * grid.vessels // grid.sizes[grid.axis] for block in blocks]
    try:
        with bar(grid.vessels, progress) as advance:
            group = opened(path, identity.hexdigest(), grid, blocks)
            left = [number for number, done in enumerate(group[DONE][:]) if not done]
            advance(grid.vessels - sum(sizes[number] for number in left))
            tasks = (
                (str(path.resolve()), fleet, grid.part(blocks[number]), grid.region(blocks[number]), number)
                for number in tuple(left)
            )
            for number in _done(client, tasks):
                left.remove(number)
                advance(sizes[number])
    except OSError as error:
        raise InputError(
            f"{path}: cannot be written ({reason(error)}); what is done stays, mend it and go on"
        ) from None
    held = xr.open_zarr(path, consolidated=False).drop_vars(DONE)
    # The voyages are the same under any labels: those of this call stand in the result.
    return held.drop_vars(held.coords).assign_coords(grid.coordinates()).assign_attrs(complete=int(not left))


def run_block(path: str, fleet: KernelRun, part: Grid, region: tuple[slice, ...], number: int) -> int:
    """Run one block, write its region, then mark it done; a repetition changes nothing."""
    import zarr

    group = zarr.open_group(path, mode="r+")
    values, shape = part.flat(slice(0, part.sizes[part.axis]))
    for name, column in fleet.run(values, math.prod(shape)).items():
        group[name][region] = column.reshape(shape)
    group[DONE][number] = True
    return number


def _done(client: Any, tasks: Iterator[tuple[str, KernelRun, Grid, tuple[slice, ...], int]]) -> Iterator[int]:
    """Run tasks here, or on a cluster, and yield the number of each that is done."""
    if client is None:
        with suppress(KeyboardInterrupt):
            yield from starmap(run_block, tasks)
        return
    from dask.distributed import as_completed

    # Each task carries all its inputs, so that a worker's death costs only that task.
    futures = [client.submit(run_block, *task, pure=False, retries=3) for task in tasks]
    for future in as_completed(futures):
        yield int(future.result())


# Array of the folder: whether each block has run.
DONE = "block_done"


def opened(path: Path, identity: str, grid: Grid, blocks: list[slice]) -> Any:
    with needs("cluster", "a store"):
        import zarr
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        _make(path, identity, grid, blocks)
    try:
        group = zarr.open_group(str(path), mode="r+")
        held = group.attrs.get("identity")
    except Exception:  # Zarr's errors on foreign folders vary
        raise InputError(f"{path}: holds no ensemble that can be read; choose another folder or remove it") from None
    if held != identity:
        raise InputError(f"{path}: holds another ensemble; choose another folder or remove it")
    return group


def _make(path: Path, identity: str, grid: Grid, blocks: list[slice]) -> None:
    """Make a temporary folder and rename it: if the process is killed, it is whole or absent."""
    making = path.parent / f".{path.name}-{uuid4().hex}"
    making.mkdir(parents=True)
    try:
        _write_empty(making, identity, grid, blocks)
        os.replace(making, path)
    except OSError:
        if not (path.is_dir() and any(path.iterdir())):  # Otherwise another process has just made it
            raise
    finally:
        shutil.rmtree(making, ignore_errors=True)


def _write_empty(path: Path, identity: str, grid: Grid, blocks: list[slice]) -> None:
    import zarr

    group = zarr.open_group(str(path), mode="w", attributes={"identity": identity})
    chunks = tuple(blocks[0].stop if name == grid.axis else n for name, n in grid.sizes.items())
    for name, kind in OUTPUTS.items():
        group.create_array(
            name, shape=tuple(grid.sizes.values()), chunks=chunks, dtype=kind, fill_value=empty_of(kind),
            attributes=attributes_of(name), dimension_names=list(grid.sizes),
        )  # fmt: skip
    group.create_array(DONE, shape=len(blocks), chunks=1, dtype=bool, dimension_names=["block"])
    try:
        xr.Dataset(coords=grid.coordinates(), attrs=dict(group.attrs)).to_zarr(path, mode="a", consolidated=False)
    except (TypeError, ValueError, NotImplementedError) as error:
        raise InputError(f"{path}: cannot hold these labels ({reason(error)}); give numbers or words") from None


# Code of a voyage that was not run.
NOT_RUN = -1
UNITS = {"time": "s", "distance": "m", "y_end": "m", "psi_end": "rad", "u_end": "m/s", "v_end": "m/s", "r_end": "rad/s"}


def empty_of(kind: type) -> Any:
    return NOT_RUN if issubclass(kind, np.integer) else np.nan


def attributes_of(name: str) -> dict[str, Any]:
    """Units, and the meaning of codes by the CF conventions."""
    if name == "outcome":
        codes = {NOT_RUN: "not run", **{int(code): kind for code, kind in KINDS.items()}}
        for code, way in WAYS.items():
            codes[int(code)] = f"{KINDS[code]} by its {way}"
        meanings = " ".join(word.replace(" ", "_") for word in codes.values())
        return {"flag_values": list(codes), "flag_meanings": meanings}
    if name == "side":
        return {"flag_values": [-1, 0, 1], "flag_meanings": "port_or_stern none starboard_or_bow"}
    long_name = {"time": "time of the end", "distance": "distance along the canal"}.get(
        name, f"{name.removesuffix('_end')} at the end"
    )
    return {"units": UNITS[name], "long_name": long_name}
