"""Functions of a model by address: a compiled loop that all models share calls them, so it is compiled once."""

from inspect import signature
from types import ModuleType
from typing import Any

import numpy as np

from narrows.codegen.cache import lacks_compiler


def entry(module: ModuleType, name: str) -> Any:
    """Compile a function of a generated module and return its address; without a compiler, the function itself.

    One that returns several numbers writes them into a last array.
    """
    if lacks_compiler():
        function = getattr(module, name)
        count = len(signature(function).parameters)
        return lambda *given: np.copyto(given[-1], function(*given[:-1])) if given[count:] else function(*given)
    from narrows.codegen.compilation import address

    return address(module, name)


def _compiled() -> Any:
    """Return what calls an address in compiled code: arrays go as the place of their numbers, all else as it is."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    def call(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        def passed(kind: Any, value: Any) -> Any:
            if not isinstance(kind, types.Array):
                return value
            return builder.bitcast(context.make_array(kind)(context, builder, value).data, ir.IntType(8).as_pointer())

        given = list(map(passed, signature.args[-1], cgutils.unpack_tuple(builder, values[-1])))
        function = ir.FunctionType(ir.IntType(64), [one.type for one in given]).as_pointer()
        return builder.call(builder.inttoptr(values[0], function), given)

    return intrinsic(lambda _, address, given: (types.int64(address, given), call))


# ``call(address, arguments)`` returns a whole number.
call: Any = (lambda function, given: function(*given)) if lacks_compiler() else _compiled()
