"""Functions of a model by address: a compiled loop that all models share calls them, so it is compiled once."""

from collections.abc import Callable
from typing import Any

from narrows.codegen.cache import lacks_compiler


def _entry(signature: Callable[[Any, Any, Any, Any], Any]) -> Any:
    """Return what makes a function of its address in compiled code; an array gives the precision."""
    if lacks_compiler():
        return lambda function, block: function
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    def of(number: Any) -> Any:
        # The table of a waterway is in double precision in every kernel.
        return signature(types, number, types.Array(number, 1, "C"), types.Array(types.float64, 1, "C"))

    @intrinsic  # type: ignore[untyped-decorator]
    def entry(context: Any, address: Any, block: Any) -> Any:
        kind = types.FunctionType(of(block.dtype))

        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            made = cgutils.create_struct_proxy(kind)(context, builder)
            pointer = context.get_value_type(types.voidptr)
            made.c_addr = builder.inttoptr(arguments[0], pointer)
            made.jit_addr = made.py_addr = cgutils.get_null_value(pointer)
            return made._getvalue()

        return kind(address, block), build

    entry.of = of
    return entry


step_at = _entry(lambda types, _, array, table: types.boolean(array, table, array))
room_at = _entry(lambda types, number, array, table: types.UniTuple(number, 2)(array, types.int64, table, array))
ends_at = _entry(
    lambda types, number, array, table: types.UniTuple(number, 4)(array, types.int64, types.int64, table, array)
)
tangent_at = _entry(lambda types, _, array, table: types.void(array, array, array, table))
balance_at = _entry(lambda types, number, array, _: types.UniTuple(number, 6)(number, number, array))


def address(function: Any, entry: Any, dtype: Any = float) -> Any:
    """Compile a function and return where it begins; without a compiler, return the function itself."""
    if lacks_compiler():
        return function
    from numba import from_dtype
    from numpy import dtype as kind_of

    signature = entry.of(from_dtype(kind_of(dtype)))
    function.compile(signature)
    compiled = function.get_compile_result(signature)
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))
