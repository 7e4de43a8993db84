"""Limit BLAS to one thread for small matrices."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Run a function with one thread of the BLAS."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        import scipy.linalg.lapack  # noqa: F401  # SciPy's own BLAS, which a limit set before its import does not reach

        with threadpool_limits(limits=1):
            return function(*args, **kwargs)

    return run
