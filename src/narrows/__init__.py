"""narrows: from captive model tests to a closed-form bank-effect model with its uncertainty.

The public names are listed in ``__init__.pyi``; each loads at its first use, so that importing the package is fast.
"""

from typing import Any

import lazy_loader

__version__ = "0.1.0"

_loaded, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    try:
        return _loaded(name)
    except AttributeError:
        if name.startswith("_"):  # Asked by inspect, IPython and others, often
            raise
        from narrows.base.aliases import function_named, public_name

        if function := function_named(name):
            return function
        raise AttributeError(f"narrows has no {name!r}{public_name(name, __all__)}") from None
