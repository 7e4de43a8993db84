"""Bytes as they come, cut into lines; what never ends is given up."""

from collections import Counter

# Bytes of a line; a sentence has 82, and some more before it.
LONGEST = 4096


class LineSplitter:
    """Cuts bytes into lines."""

    def __init__(self, faults: Counter[str]) -> None:
        self.faults = faults
        self._rest = b""

    def lines(self, piece: bytes, whole: bool = False) -> list[bytes]:
        """Return the lines that a piece completes."""
        *lines, rest = (self._rest + piece).replace(b"\r", b"\n").split(b"\n")
        if whole:
            lines, rest = [*lines, rest], b""
        if len(rest) > LONGEST:
            self.faults["that never ended"] += 1
            rest = b""
        self._rest = rest
        return [line for line in lines if line]
