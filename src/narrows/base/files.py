"""Files: written whole or not at all, in the format of the suffix; read or refused in one sentence."""

import json
import math
import os
import re
import stat
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from errno import EACCES
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np

from narrows.base.errors import InputError, needs, reason

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.figure import Figure

PICTURES = (".png", ".svg", ".pdf")


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file so that a reader finds the old one or the new one, never a part."""
    # A symbolic link stays and the file behind it is replaced, which keeps its mode; a new file has the mode that the
    # umask leaves. Devices, FIFOs and open descriptors (``/dev/stdout``) are written to as they are.
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        if is_stream(path):
            if sys.stdout is not None:
                sys.stdout.flush()  # Earlier output comes first
            # If reopened, a redirected output would be overwritten from its beginning; a device is never created.
            with open(os.dup(1) if _is_output(path) else os.open(path, os.O_WRONLY), "wb") as file:
                file.write(data)
        else:
            _replace(Path(os.path.realpath(path)), data)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written ({reason(error)}); check its folder and the disk") from None


def is_stream(path: str | Path) -> bool:
    """Return whether a path is a stream: a device, a FIFO or ``/dev/stdout``."""
    try:
        kind = os.stat(path).st_mode
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)) or _is_output(path)


def _is_output(path: str | Path) -> bool:
    """Return whether a path leads to the standard output, which may be a file of the shell."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(1))
    except OSError:
        return False


@contextmanager
def reading(path: str | Path, kind: str) -> Iterator[None]:
    """Turn any error of a format's reader into one sentence with the file."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        found = "there is no such file" if missing else f"cannot be read ({reason(error)})"
        raise InputError(f"{path}: {found}; check the path") from None
    except Exception as error:  # Readers raise many kinds of errors on files of another format
        raise InputError(f"{path}: is not {kind} ({reason(error)}); mend it, or give another file") from None


def form_of(path: str | Path, forms: tuple[str, ...]) -> str:
    """Return the format of a file by its suffix, or the first one for a device without one."""
    suffix = Path(path).suffix.lower() or (forms[0] if is_stream(path) else "")
    if suffix not in forms:
        picture = "; for a picture use --plot" if suffix in PICTURES else ""
        raise InputError(
            f"{path}: cannot write a {suffix[1:] or 'nameless'} file here; name it {', '.join(forms)}{picture}"
        )
    return suffix


def netcdf_of(dataset: "xarray.Dataset", path: str | Path) -> bytes:
    try:
        return bytes(dataset.to_netcdf(engine="scipy"))
    except (TypeError, ValueError, OverflowError, NotImplementedError) as error:
        raise InputError(f"{path}: NetCDF does not hold these labels ({reason(error)}); give others") from None


def parquet_of(frame: "pd.DataFrame", words: Mapping[str, str], path: str | Path) -> bytes:
    frame = frame.copy(deep=False)
    frame.attrs.update(words)
    with needs("parquet", f"{path}: Parquet"):
        return bytes(frame.to_parquet(None))


def matlab_of(columns: Mapping[str, Any]) -> bytes:
    """Return columns as a MATLAB file, up to version 7: vectors and arrays by name."""
    from scipy.io import savemat

    memory: Any = BytesIO()
    plain = {name: re.sub(r"\W+", "_", str(name), flags=re.ASCII).strip("_") for name in columns}
    names = {name: word if word[:1].isalpha() else f"column{word}" for name, word in plain.items()}
    if len(set(names.values())) < len(names):
        raise InputError(f"in MATLAB {', '.join(map(str, columns))} are not all different; rename one")
    savemat(memory, {names[name]: column for name, column in columns.items()}, long_field_names=True, oned_as="column")
    return bytes(memory.getvalue())


def picture_of(figure: "Figure", suffix: str) -> bytes:
    memory = BytesIO()
    figure.savefig(memory, format=suffix[1:], dpi=150)
    return memory.getvalue()


def save_figure(figure: "Figure", path: str | Path) -> None:
    write_whole(path, picture_of(figure, form_of(path, PICTURES)))


def _replace(path: Path, data: bytes) -> None:
    known = path.stat() if os.path.lexists(path) else None
    if known and not os.access(path, os.W_OK):
        raise PermissionError(EACCES, os.strerror(EACCES))
    temporary = path.parent / f".narrows-{uuid4().hex}"
    try:
        with temporary.open("xb") as file:
            file.write(data)
        if known:  # The new file has the mode of the old one, and its owner if allowed
            with suppress(OSError, AttributeError):
                os.chown(temporary, known.st_uid, known.st_gid)
            temporary.chmod(stat.S_IMODE(known.st_mode))
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


# Makes a file's content, or writes the file itself.
Form = Callable[[], str | bytes | None]
# Returns the descriptions of a table, by name.
Words = Callable[[], dict[str, str]]
# Suffixes by the libraries' names of formats, as in ``to_netcdf``.
FORMS = {"netcdf": ".nc", "parquet": ".parquet", "mat": ".mat", "geojson": ".geojson"}


def save_dataset(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write a dataset in the format of the suffix, whole or not at all."""
    forms = _dataset_forms(dataset, path) | {".json": lambda: to_json(_as_mapping(dataset))}
    write(forms, path)


def write(forms: Mapping[str, Form], path: str | Path) -> None:
    content = forms[form_of(path, tuple(forms))]()
    if content is not None:
        write_whole(path, content)


def forms_of(result: Any, path: str | Path) -> dict[str, Form]:
    """Return a result's formats by suffix; the first is used for a device."""
    forms: dict[str, Form] = {}
    if hasattr(result, "dataset"):
        forms |= _dataset_forms(result.dataset(), path)
    if hasattr(result, "to_dataframe"):
        forms |= _table_forms(
            result.to_dataframe, path, lambda: {"summary": result.summary(), "notes": "\n".join(result.notes)}
        )
    forms[".json"] = lambda: to_json(
        {**result.to_dict(), **({"data": _as_mapping(result.dataset())} if hasattr(result, "dataset") else {})}
    )
    if hasattr(result, "geojson"):
        forms[".geojson"] = result.geojson
    if hasattr(result, "animate"):
        forms[".gif"] = lambda: result.animate(path) and None
    return forms | {suffix: lambda kind=suffix: picture_of(result.plot(), kind) for suffix in PICTURES}


def _table_forms(table: Callable[[], "pd.DataFrame"], path: str | Path, words: Words) -> dict[str, Form]:
    return {
        ".csv": lambda: csv_of(table()),
        ".parquet": lambda: parquet_of(table(), words(), path),
        ".mat": lambda: matlab_of({str(name): column.to_numpy() for name, column in table().items()} | words()),
    }


def _dataset_forms(dataset: "xarray.Dataset", path: str | Path) -> dict[str, Form]:
    def rows() -> "pd.DataFrame":
        frame: pd.DataFrame = dataset.to_dataframe() if dataset.sizes else dataset.expand_dims("row").to_dataframe()
        return frame.reset_index()

    def words() -> dict[str, str]:
        return {str(name): value for name, value in dataset.attrs.items() if isinstance(value, str)}

    arrays = {str(name): variable.to_numpy() for name, variable in dataset.variables.items()}
    return {
        ".nc": lambda: netcdf_of(dataset, path),
        **_table_forms(rows, path, words),
        ".mat": lambda: matlab_of(words() | arrays),
    }


def _as_mapping(dataset: "xarray.Dataset") -> dict[str, Any]:
    return {
        "attributes": dict(dataset.attrs),
        "coordinates": {str(name): _column(coordinate) for name, coordinate in dataset.coords.items()},
        "variables": {str(name): _column(variable) for name, variable in dataset.data_vars.items()},
    }


def _column(array: "xarray.DataArray") -> dict[str, Any]:
    return {"dimensions": list(array.dims), "unit": array.attrs.get("units", ""), "values": array.to_numpy()}


def csv_of(frame: Any, **options: Any) -> str:
    """Return a table as text; unnamed rows are not numbered."""
    return str(frame.to_csv(**{"index": frame.index.names != [None], **options}))


# The one conversion of results to JSON.
def plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, Iterable):
        return [plain(part) for part in value]
    raise TypeError(f"{type(value).__name__} has no place in JSON")


def to_json(value: Any) -> str:
    """Write a value, or a result's ``to_dict()``, as JSON."""
    return json.dumps(plain(value), indent=2, allow_nan=False)
