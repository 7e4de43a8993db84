"""Bytes as they come, cut into lines; what never ends is given up."""

from collections import Counter

LONGEST = 4096
"""Bytes of a line; a sentence has 82, and some more before it."""


class LineSplitter:
    """Cuts bytes into lines.

    Parameters
    ----------
    faults : Counter
        Counts what was given up.
    """

    def __init__(self, faults: Counter[str]) -> None:
        self.faults = faults
        self._rest = b""

    def lines(self, piece: bytes, whole: bool = False) -> list[bytes]:
        """Return the lines that a piece completes (ours).

        Parameters
        ----------
        piece : bytes
            As it came.
        whole : bool
            Whether its end is the end of a line, as that of a datagram is.
        """
        *lines, rest = (self._rest + piece).replace(b"\r", b"\n").split(b"\n")
        if whole:
            lines, rest = [*lines, rest], b""
        if len(rest) > LONGEST:
            self.faults["that never ended"] += 1
            rest = b""
        self._rest = rest
        return [line for line in lines if line]
