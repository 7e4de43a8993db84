"""Ensembles larger than memory or one machine: blocks in Zarr, resumable, on threads or on Dask."""

import hashlib
import math
import os
import shutil
import time
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import xarray as xr

from narrows.errors import InputError, needs, reason, shown
from narrows.progress import bar
from narrows.simulation.grid import Grid
from narrows.simulation.kernel_run import OUTPUTS, KernelRun
from narrows.simulation.outcome import KINDS, WAYS
from narrows.simulation.settings import TASK_VESSELS


def run_into(path: Path, fleet: KernelRun, grid: Grid, client: Any, progress: bool) -> xr.Dataset:
    """Run the missing blocks of an ensemble into a Zarr folder, and open it."""
    if client is not None and not hasattr(client, "submit"):
        raise InputError(f"client = {shown(client)} is none; give a dask.distributed.Client")
    blocks = list(grid.blocks(TASK_VESSELS))
    with storing(path), bar(grid.vessels, progress) as advance:
        group = opened(path, _identity(fleet, grid), grid, blocks)
        left = {number for number, block in enumerate(blocks) if not is_done(group, grid.region(block), number)}
        for number in left:
            discard(path, group, grid, number)
        advance(sum(_vessels(grid, block) for number, block in enumerate(blocks) if number not in left))
        tasks = (
            (str(path.resolve()), fleet, grid.part(blocks[number]), grid.region(blocks[number]), number)
            for number in sorted(left)
        )
        for number in _here(tasks) if client is None else _there(client, tasks):
            left.discard(number)
            advance(_vessels(grid, blocks[number]))
        return xr.open_zarr(path, consolidated=False).drop_vars(DONE).assign_attrs(complete=int(not left))


def run_block(path: str, fleet: KernelRun, part: Grid, region: tuple[slice, ...], number: int) -> int:
    """Run one block, write its region, then mark it done; a repetition changes nothing."""
    import zarr

    group = zarr.open_group(path, mode="r+")
    values, shape = part.flat(slice(0, part.sizes[part.axis]))
    columns = fleet.run(values, math.prod(shape))
    for name, column in columns.items():
        group[name][region] = column.reshape(shape)
    group[DONE][number] = checksum(columns)
    return number


Tasks = Iterator[tuple[str, KernelRun, Grid, tuple[slice, ...], int]]


def _here(tasks: Tasks) -> Iterator[int]:
    try:
        for task in tasks:
            yield run_block(*task)
    except KeyboardInterrupt:
        return


def _there(client: Any, tasks: Tasks) -> Iterator[int]:
    """Each task carries all its inputs, so that a worker's death costs only that task."""
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


# Array with a checksum for each block of the folder; 0 if it has not run.
DONE = "block_checksum"
# Name of unfinished folders, and the age [s] after which one counts as abandoned.
MAKING, LEFTOVER = ".narrows-store-", 3600.0


@contextmanager
def storing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(
            f"{path}: cannot be written ({reason(error)}); what is done stays, mend it and go on"
        ) from None


def opened(path: Path, identity: str, grid: Grid, blocks: list[slice]) -> Any:
    """Open the folder of an ensemble, made if absent, with the current labels."""
    # Labels do not identify an ensemble: the voyages are the same under any.
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
    if not _columns_are_sound(group, grid, blocks):
        _make_columns(group, grid, blocks)
    if not _labels_are_sound(path, grid):
        _write_labels(path, group, grid)
    return group


def checksum(columns: Mapping[str, np.ndarray]) -> int:
    """Return a number that depends on all columns of a block, never 0."""
    number = 0
    for name, kind in OUTPUTS.items():
        number = zlib.crc32(np.ascontiguousarray(columns[name], dtype=kind).tobytes(), number)
    return number or 1


def is_done(group: Any, region: tuple[slice, ...], number: int) -> bool:
    try:
        marked = int(group[DONE][number])
        return marked != 0 and marked == checksum({name: group[name][region] for name in OUTPUTS})
    except Exception:  # Decoders raise various errors on damaged data: the block runs again
        return False


def discard(path: Path, group: Any, grid: Grid, number: int) -> None:
    """Remove the stored data of a block, so that nothing damaged is read when it is written again."""
    chunk = tuple(number if name == grid.axis else 0 for name in grid.sizes)
    for name, chunk_index in {**dict.fromkeys(OUTPUTS, chunk), DONE: (number,)}.items():
        file = path / name / group[name].metadata.encode_chunk_key(chunk_index)
        shutil.rmtree(file) if file.is_dir() else file.unlink(missing_ok=True)


def _make(path: Path, identity: str, grid: Grid, blocks: list[slice]) -> None:
    """Make a temporary folder and rename it: if the process is killed, it is whole or absent."""
    import zarr

    path.parent.mkdir(parents=True, exist_ok=True)
    _sweep(path.parent)
    making = path.parent / f"{MAKING}{uuid4().hex}"
    try:
        group = zarr.open_group(str(making), mode="w")
        _make_columns(group, grid, blocks)
        group.attrs["identity"] = identity
        _write_labels(making, group, grid)
        _move(making, path)
    finally:
        shutil.rmtree(making, ignore_errors=True)


def _move(making: Path, path: Path) -> None:
    try:
        os.replace(making, path)
    except OSError:
        if not (path.is_dir() and any(path.iterdir())):  # Otherwise another process has just made it
            raise


def _sweep(folder: Path) -> None:
    """Remove leftovers of killed processes."""
    for left in folder.glob(f"{MAKING}*"):
        if time.time() - left.stat().st_mtime > LEFTOVER:
            shutil.rmtree(left, ignore_errors=True)


def _shapes(grid: Grid, blocks: list[slice]) -> dict[str, tuple[tuple[int, ...], tuple[int, ...], np.dtype]]:
    """Shape, chunks and kind of every array."""
    shape = tuple(grid.sizes.values())
    chunks = tuple(blocks[0].stop if name == grid.axis else n for name, n in grid.sizes.items())
    columns = {name: (shape, chunks, np.dtype(kind)) for name, kind in OUTPUTS.items()}
    return {**columns, DONE: ((len(blocks),), (1,), np.dtype(np.uint32))}


def _columns_are_sound(group: Any, grid: Grid, blocks: list[slice]) -> bool:
    try:
        return all(
            (group[name].shape, group[name].chunks, group[name].dtype) == known
            for name, known in _shapes(grid, blocks).items()
        )
    except Exception:  # Truncated metadata count as none
        return False


def _make_columns(group: Any, grid: Grid, blocks: list[slice]) -> None:
    for name, (shape, chunks, kind) in _shapes(grid, blocks).items():
        mark = name == DONE
        group.create_array(
            name, shape=shape, chunks=chunks, dtype=kind, overwrite=True,
            fill_value=0 if mark else empty_of(kind.type), attributes={} if mark else attributes_of(name),
            dimension_names=["block"] if mark else list(grid.sizes),
        )  # fmt: skip


def _labels_are_sound(path: Path, grid: Grid) -> bool:
    try:
        with xr.open_zarr(path, consolidated=False) as held:
            return bool(xr.Dataset(coords=held.coords).load().identical(xr.Dataset(coords=grid.coordinates())))
    except Exception:  # Damaged labels are written again
        return False


def _write_labels(path: Path, group: Any, grid: Grid) -> None:
    for entry in path.iterdir():
        if entry.is_dir() and entry.name not in (*OUTPUTS, DONE):
            shutil.rmtree(entry)
    coordinates = grid.coordinates()
    if not coordinates:
        return
    try:
        xr.Dataset(coords=coordinates, attrs=dict(group.attrs)).to_zarr(path, mode="a", consolidated=False)
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
