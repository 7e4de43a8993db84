"""Datasets to NetCDF files, whole or not at all."""

from pathlib import Path
from typing import TYPE_CHECKING

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
        Where the file cannot be written.
    """
    write_whole(path, bytes(dataset.to_netcdf(engine="scipy")))
