"""Compilation: straight lines of Python by LLVM, for one vessel or in loops over lanes; other loops by Numba.

Numba infers types and counts references, which takes seconds where formulas are long. A straight line of numbers needs
neither; LLVM makes vectors of the loops over lanes. What both compile is kept in checked files.
"""

import ast
import hashlib
import pickle
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from types import ModuleType
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core.caching import IndexDataCacheFile

from narrows.base.errors import InputError
from narrows.base.files import write_whole

INTEGER, BOOLEAN, DOUBLE = ir.IntType(64), ir.IntType(1), ir.DoubleType()
# Arguments that are arrays, and whole numbers; all others are numbers.
ARRAYS = ("block", "table", "shared", "z", "inputs", "values", "constants")
INTEGERS = ("lane", "first")
SIZE = 8  # Bytes of a number
# Fused multiply-add, nothing reordered: the mirrored voyage is the mirror to the bit.
FAST = ("nsz", "contract")
ARITHMETIC = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "div", ast.LShift: "shl", ast.BitAnd: "and_"}
COMPARED = {ast.Lt: "<", ast.Gt: ">", ast.LtE: "<=", ast.GtE: ">=", ast.Eq: "=="}
INTRINSICS = {"abs": "fabs", "sqrt": "sqrt", "log": "log", "sin": "sin", "cos": "cos"}

Value = Any  # An LLVM value, a number of Python, or a tuple of them

DIGEST = hashlib.sha256().digest_size  # Files of compiled code begin with the hash of the rest

_ENGINES: list[Any] = []  # An engine owns the code that it made


@cache
def address(module: ModuleType, name: str) -> int:
    """Compile a function of a generated module, or read what an earlier process compiled; return its address."""
    machine, processor = this_machine()
    path = Path(str(module.__file__)).with_suffix(f".{name}.{hashlib.sha256(processor.encode()).hexdigest()[:12]}.o")
    text = vars(module)["TEXT"].encode()
    if (code := unsealed(path, text)) is None:
        code = machine.emit_object(optimised(module, name, machine))
        with suppress(InputError):
            write_whole(path, sealed(code, text))
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _ENGINES.append(engine)
    return int(engine.get_function_address(name))


def sealed(content: bytes, about: bytes = b"") -> bytes:
    """Return a content after the hash of what it is about and of itself."""
    return hashlib.sha256(about + content).digest() + content


def unsealed(path: str | Path, about: bytes = b"") -> bytes | None:
    """Return the sealed content of a file, None if it is absent, damaged or about something else."""
    with suppress(OSError):
        kept = Path(path).read_bytes()
        if kept == sealed(kept[DIGEST:], about):
            return kept[DIGEST:]
    return None


@cache
def this_machine() -> tuple[Any, str]:
    """Return what writes code for this processor, and the processor's name and features."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    name, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    if "+avx2" in features:  # Many processors gather from a table more slowly than they read number by number
        features += ",+prefer-no-gather"
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(name, features, opt=3, codemodel="jitdefault", jit=True), name + features


def optimised(module: ModuleType, name: str, machine: Any) -> Any:
    """Return a function as optimised code of LLVM."""
    compiled = llvm.parse_assembly(str(Compiler(vars(module)["TEXT"]).function(name).module))
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=3))
    builder.getModulePassManager().run(compiled, builder)
    return compiled


class Compiler:
    """Writes functions of a module's text as LLVM code; the functions that they call are inlined."""

    def __init__(self, text: str) -> None:
        body = ast.parse(text).body
        self.functions = {node.name: node for node in body if isinstance(node, ast.FunctionDef)}
        assigned = [node for node in body if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)]
        self.constants: dict[str, Any] = {node.targets[0].id: node.value.value for node in assigned}  # type: ignore[attr-defined]
        self.module = ir.Module()

    def function(self, name: str) -> ir.Function:
        """Write a function; where it returns a tuple, a last array takes the results."""
        node = self.functions[name]
        names = [one.arg for one in node.args.args]
        last = node.body[-1]
        if isinstance(last, ast.Return) and isinstance(last.value, ast.Tuple):
            names.append("results")
        arrays = (*ARRAYS, "results")
        kinds = [ir.PointerType() if n in arrays else INTEGER if n in INTEGERS else DOUBLE for n in names]
        function = ir.Function(self.module, ir.FunctionType(INTEGER, kinds), name)
        for one in function.args:
            if isinstance(one.type, ir.PointerType):
                one.add_attribute("noalias")
        builder = ir.IRBuilder(function.append_basic_block())
        body = Body(self, builder, dict(zip(names, function.args, strict=True)))
        result = body.run(node.body)
        if isinstance(result, tuple):
            for place, value in enumerate(result):
                body.store(function.args[-1], place, value)
        builder.ret(INTEGER(0) if result is None or isinstance(result, tuple) else result)
        return function


class Body:
    """Statements of a function, written where a builder stands."""

    def __init__(self, compiler: Compiler, builder: ir.IRBuilder, scope: dict[str, Value]) -> None:
        self.compiler, self.builder, self.scope = compiler, builder, scope

    def run(self, statements: Sequence[ast.stmt]) -> Value:
        for statement in statements:
            match statement:
                case ast.Return():
                    return self.value(statement.value) if statement.value else None
                case ast.Assign(targets=[ast.Subscript(value=array, slice=place)]):
                    self.store(self.value(array), self._index(place), self.value(statement.value))
                case ast.Assign(targets=[ast.Tuple(elts=names)]):
                    self.scope.update(zip((one.id for one in names), self.value(statement.value), strict=True))  # type: ignore[attr-defined]
                case ast.Assign(targets=[ast.Name(id=name)]):
                    self.scope[name] = self.value(statement.value)
                case ast.For(target=ast.Name(id=lane), iter=ast.Call(args=[ast.Constant(value=count)])):
                    self._loop(lane, int(str(count)), statement.body)
                case _:
                    raise TypeError(f"no straight line: {ast.unparse(statement)}")
        return None

    def _loop(self, lane: str, count: int, body: Sequence[ast.stmt]) -> None:
        """Write a loop over lanes; flags set before it are carried through it."""
        builder, before, begun = self.builder, self.builder.block, self.builder.append_basic_block()
        builder.branch(begun)
        builder.position_at_end(begun)
        targets = [node.targets[0] for node in body if isinstance(node, ast.Assign)]
        assigned = {target.id for target in targets if isinstance(target, ast.Name)}
        phis = {name: builder.phi(BOOLEAN) for name in sorted(self.scope.keys() & assigned)}
        first = builder.phi(INTEGER)
        inside = Body(self.compiler, builder, {**self.scope, **phis, lane: first})
        inside.run(body)
        ahead, after = builder.add(first, INTEGER(1)), builder.append_basic_block()
        for name, phi in phis.items():
            phi.add_incoming(self._as(self.scope[name], BOOLEAN), before)
            phi.add_incoming(inside.scope[name], builder.block)
        first.add_incoming(INTEGER(0), before)
        first.add_incoming(ahead, builder.block)
        builder.cbranch(builder.icmp_unsigned("<", ahead, INTEGER(count)), begun, after)
        builder.position_at_end(after)
        self.scope.update({name: inside.scope[name] for name in phis})

    def value(self, node: ast.expr) -> Value:
        builder = self.builder
        match node:
            case ast.Constant():
                return node.value
            case ast.Name(id=name):
                return self.scope[name] if name in self.scope else self.compiler.constants[name]
            case ast.Tuple(elts=parts):
                return tuple(map(self.value, parts))
            case ast.UnaryOp(operand=operand):
                value = self.value(operand)
                return builder.fneg(value, FAST) if isinstance(value, ir.Value) else -value
            case ast.BinOp(left=left, op=operator, right=right):
                return self._arithmetic(operator, self.value(left), self.value(right))
            case ast.Compare(left=left, ops=[sign], comparators=[right]):
                return builder.fcmp_ordered(COMPARED[type(sign)], *self._alike(self.value(left), self.value(right)))
            case ast.IfExp(test=test, body=over, orelse=under):
                values = (self._as(self.value(one), DOUBLE) for one in (over, under))
                return builder.select(self.value(test), *values)
            case ast.Subscript(value=array, slice=place):
                return builder.load(self._place(self.value(array), self._index(place)), align=SIZE, typ=DOUBLE)
            case ast.Call(func=ast.Name(id=name), args=given):
                return self._called(name, [self.value(one) for one in given])
            case ast.Call(func=ast.Attribute(value=value, attr="view"), args=[kind]):
                return builder.bitcast(self.value(value), DOUBLE if isinstance(kind, ast.Name) else INTEGER)
            case ast.Call(func=ast.Attribute(value=ast.Name(id="np")), args=[number]):
                value = self.value(number)
                return value if value.type == INTEGER else builder.fptosi(value, INTEGER)
        raise TypeError(f"no straight line: {ast.unparse(node)}")

    def _index(self, place: ast.expr) -> Value:
        """Write a place in an array; a field of a lane is one in the rows of a block."""
        at = self.value(place)
        if not isinstance(at, tuple):
            return at
        row = self._arithmetic(ast.Mult(), at[0], self.compiler.constants["LANES"])
        return self._arithmetic(ast.Add(), row, at[1])

    def _arithmetic(self, operator: ast.operator, left: Value, right: Value) -> Value:
        if not isinstance(left, ir.Value) and not isinstance(right, ir.Value):  # places in an array
            return left * right if isinstance(operator, ast.Mult) else left + right
        left, right = self._alike(left, right)
        if isinstance(operator, ast.Pow):
            return self._intrinsic("pow", left, right)
        name = ARITHMETIC[type(operator)]
        if isinstance(left.type, ir.IntType):
            return getattr(self.builder, name)(left, right)
        return getattr(self.builder, f"f{name}")(left, right, flags=FAST)

    def _called(self, name: str, given: list[Value]) -> Value:
        builder = self.builder
        if name in INTRINSICS:
            return self._intrinsic(INTRINSICS[name], *given)
        if name == "any_false":
            return builder.zext(builder.not_(given[0]), INTEGER)
        if name == "real":
            whole = isinstance(given[0], ir.Value) and given[0].type == INTEGER
            return builder.sitofp(given[0], DOUBLE) if whole else given[0]
        if name == "int":
            return builder.fptosi(given[0], INTEGER) if isinstance(given[0], ir.Value) else given[0]
        function = self.compiler.functions[name]
        scope = dict(zip((one.arg for one in function.args.args), given, strict=True))
        return Body(self.compiler, builder, scope).run(function.body)

    def _intrinsic(self, name: str, *given: Value) -> Value:
        given = self._alike(*given)
        signature = ir.FunctionType(DOUBLE, [DOUBLE] * len(given))
        function = self.compiler.module.declare_intrinsic(f"llvm.{name}.f64", (), signature)
        return self.builder.call(function, given, fastmath=FAST)

    def store(self, array: Value, place: Value, value: Value) -> None:
        self.builder.store(self._as(value, DOUBLE), self._place(array, place), align=SIZE)

    def _place(self, array: Value, place: Value) -> Value:
        at = place if isinstance(place, ir.Value) else INTEGER(place)
        return self.builder.gep(array, [at], source_etype=DOUBLE)

    def _alike(self, *values: Value) -> tuple[Value, ...]:
        """Return values of one type: numbers of Python as constants."""
        kind = next(one.type for one in values if isinstance(one, ir.Value))
        return tuple(self._as(one, kind) for one in values)

    @staticmethod
    def _as(value: Value, kind: ir.Type) -> Value:
        return value if isinstance(value, ir.Value) else kind(int(value) if kind is not DOUBLE else float(value))


# Numba does not check its files: a truncated one ends in a traceback, and corrupt machine code in worse. So a damaged
# file is compiled again, and an unwritable one is ignored.
class CheckedFile(IndexDataCacheFile):  # type: ignore[misc]
    """One file per signature of a function, named by the signature, which begins with the hash of its content.

    Numba numbers the files in an index: two processes that compile two signatures at once get the same number, and one
    of them runs the other's code.
    """

    def save(self, key: Any, data: Any) -> None:
        kept = self._dump((self._version, self._source_stamp, key, data))
        with self._open_for_write(self._place(key)) as file:
            file.write(sealed(kept))

    def load(self, key: Any) -> Any:
        """Read the code of a signature; None if it is absent, damaged or of another version."""
        if (kept := unsealed(self._place(key))) is None:
            return None
        *known, data = pickle.loads(kept)
        return data if known == [self._version, self._source_stamp, key] else None

    def _place(self, key: Any) -> str:
        return str(self._data_path(self._data_name(int(hashlib.sha256(repr(key).encode()).hexdigest()[:12], 16))))


def check_files(module: ModuleType) -> None:
    """Keep what Numba compiles for a module in checked files; its functions compile even if the disk fails."""
    for value in vars(module).values():
        cache: Any = getattr(value, "_cache", None)
        if hasattr(cache, "_cache_file"):
            cache._cache_file.__class__ = CheckedFile
            cache.save_overload = partial(_saved, cache.save_overload)


def _saved(save: Callable[..., None], *compiled: Any) -> None:
    with suppress(OSError):
        save(*compiled)
