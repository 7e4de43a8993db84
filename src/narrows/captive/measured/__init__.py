"""Measured tests bundled with the package, cited in the README of this folder."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.base.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from narrows.captive.tests import CaptiveTests

TABLES = {"kcs": "kcs_pmm_shallow.csv", "lataire2009": "lataire2009.csv"}


def measured_files(name: str) -> tuple[Path, Path]:
    if name not in TABLES:
        raise InputError(f"no bundled tests are called {name!r}{did_you_mean(name, TABLES)}")
    folder = Path(__file__).parent
    return folder / TABLES[name], folder / f"{name}.toml"


def measured_tests(name: str = "kcs", where: str | None = None) -> "CaptiveTests":
    """Read some bundled tests.

    Raises an InputError if there are no such tests.

    Parameters
    ----------
    name : str
        ``kcs``: harmonic sway and yaw of the KCS in a tank 7 m wide at three depths; ``lataire2009``: steady
        tests along sloped banks.
    where : str, optional
        Which rows to take, as in ``read_captive``.

    Examples
    --------
    >>> sorted(nw.measured_tests("kcs").by_condition())
    ['C0101A01', 'C0101A02', 'C0101A03']
    """
    from narrows.captive.read import read_captive

    return read_captive(*measured_files(name), where)
