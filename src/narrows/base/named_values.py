"""Values by name: coefficients, forces, errors by force."""

from collections.abc import Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from narrows.base.errors import InputError, did_you_mean

Row = TypeVar("Row")


def by_name(what: str, rows: Iterable[tuple[str, Row]]) -> dict[str, Row]:
    """Rows of a registry by name; raises an InputError if two have one name, for one of them would be lost."""
    found = dict[str, Row]()
    for name, row in rows:
        if name in found:
            raise InputError(f"two {what} are called {name!r}; rename one")
        found[name] = row
    return found


class Named(dict[str, Any]):
    """Values by name, which are attributes too; otherwise it answers as a pandas Series, or a table of tuples.

    A call returns it again, or the value of a name, since such values are methods in some libraries.
    """

    def __call__(self, *names: Any, **given: Any) -> Any:
        if given or len(names) > 1 or not self.keys() >= {*names}:
            raise InputError(f"these values take no arguments, but one name at most: {', '.join(self)}")
        return self[names[0]] if names else self

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return np.array([*self.values()], dtype)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name in self:
                return self[name]
            if name.startswith("_"):
                raise AttributeError(name)
            import pandas as pd

            if name in ("to_pandas", "to_series"):
                return partial(pd.Series, self)
            rows = {key: value._asdict() for key, value in self.items() if hasattr(value, "_asdict")}
            table: Any = pd.DataFrame(rows).T if rows else pd.Series(self)
            if name == "to_dataframe":
                return partial(pd.DataFrame, table)
            if not hasattr(table, name):
                raise AttributeError(f"there is no {name!r} here{did_you_mean(name, self)}")
            return getattr(table, name)


class Forces(Named):
    """Forces by name; ``X, Y, N = model.forces(...)`` unpacks their values."""

    def __iter__(self) -> Iterator[Any]:
        return iter(self.values())


class Coefficients(Named):
    """Values of a model, which do not change in place: its verdicts and covariance would not follow."""

    def _refuse(self, *values: Any, **given: Any) -> Any:
        raise InputError("coefficients do not change in place; write model.with_coefficients(...), a copy")

    __setitem__ = __delitem__ = __setattr__ = __delattr__ = __ior__ = _refuse
    update = pop = popitem = setdefault = clear = _refuse

    def __missing__(self, name: str) -> Any:
        bank = [own for own in self if own.endswith("_bank") and str(name).endswith("_bank")]
        near = f"; those of the bank are {', '.join(bank)}" if bank else did_you_mean(name, self)
        raise KeyError(f"unknown coefficient {name!r}{near}")

    def __reduce__(self) -> Any:
        return type(self), (dict(self),)
