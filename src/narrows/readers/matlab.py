"""What a .mat file must be before SciPy may read it: its reader ends the whole process on types that it does not know.

A file of MATLAB 5 to 7.2 is 128 bytes of header, then elements: a type and a length, which may share four bytes where
the data do, the data, and zeros up to a multiple of eight bytes. A matrix holds elements of its own.

References
----------
MathWorks, MAT-File Format (R2024a), chapter 1: Level 5 MAT-File Format.
"""

import struct
import zlib
from collections.abc import Iterator

HEADER = 128
MATRIX, COMPRESSED = 14, 15
# Types of numbers and of characters.
NUMBERS = (1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18)
# Types of the first three elements of a matrix.
FLAGS, SHAPE, NAME = 6, (5, 6), (1, 16)
CHARACTERS, SPARSE, OPAQUE = 4, 5, 17
# Elements of a matrix by its class, where all of them are numbers; an imaginary part is one more.
PARTS = {CHARACTERS: 4, SPARSE: 6, **dict.fromkeys(range(6, 16), 4)}
DEEPEST = 50


def check_elements(content: bytes) -> None:
    """Raise where a file is of MATLAB 5 to 7.2 and one of its elements is none."""
    if len(content) < HEADER or 0 in content[:4] or content[124:128] not in (b"\0\1IM", b"\1\0MI"):
        return  # Of another version, whose readers are safe.
    _check(memoryview(content)[HEADER:], "<" if content[126:128] == b"IM" else ">", 0)


def _check(data: memoryview, order: str, depth: int) -> None:
    """Look through elements that stand one after the other."""
    for kind, body in _elements(data, order):
        if depth > DEEPEST:
            raise ValueError("nested too deeply")
        if kind == COMPRESSED:
            _check(memoryview(zlib.decompress(body)), order, depth + 1)
        if kind == MATRIX and body:
            _check_matrix(body, order)
            _check(body, order, depth + 1)


def _check_matrix(body: memoryview, order: str) -> None:
    """Look at the first parts of a matrix, and whether plain numbers and words have all of theirs."""
    parts = list(_elements(body, order))
    if len(parts) < 3 or parts[0][0] != FLAGS or len(parts[0][1]) != 8:
        raise ValueError("a matrix does not begin as one")
    flags = struct.unpack(f"{order}I", parts[0][1][:4])[0]
    of, is_complex = flags & 0xFF, bool(flags & 0x800)
    if of != OPAQUE and (parts[1][0] not in SHAPE or parts[2][0] not in NAME):
        raise ValueError("a matrix has no shape or no name")
    plain = all(kind in NUMBERS for kind, _ in parts)
    if not 1 <= of <= OPAQUE or (of in PARTS and not (plain and len(parts) == PARTS[of] + is_complex)):
        raise ValueError("a matrix has no known class, or not the parts of its class")


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Each element's type and data."""
    while data:
        kind, start, size = _tag(data, order)
        body = data[start : start + size]
        if len(body) < size or kind not in (*NUMBERS, MATRIX, COMPRESSED):
            raise ValueError("an element is cut short or of no known type")
        yield kind, body
        data = data[start + size if kind == COMPRESSED else -(-(start + size) // 8) * 8 :]


def _tag(data: memoryview, order: str) -> tuple[int, int, int]:
    """Type, where the data start, and their length."""
    if len(data) < 8:
        raise ValueError("an element is cut short")
    first, second = struct.unpack(f"{order}II", data[:8])
    return (first & 0xFFFF, 4, first >> 16) if first >> 16 else (first, 8, second)
