"""Datasets to NetCDF files, whole or not at all."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.errors import InputError, reason
from narrows.files import write_whole

if TYPE_CHECKING:
    import xarray


def save_netcdf(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write a dataset as NetCDF.

    Parameters
    ----------
    dataset : Dataset
        Of a voyage or of an ensemble.
    path : str or Path
        Where to.

    Raises
    ------
    InputError
        Where the file cannot be written, or its format does not hold the labels of the dataset.
    """
    try:
        content = bytes(dataset.to_netcdf(engine="scipy"))
    except (TypeError, ValueError, OverflowError, NotImplementedError) as error:
        raise InputError(f"{path}: NetCDF does not hold these labels ({reason(error)}); give others") from None
    write_whole(path, content)
