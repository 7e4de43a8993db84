"""Where numbers come from."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Source:
    """Where numbers come from.

    Parameters
    ----------
    text : str
        A citation, or how they were made.
    table : str
        File name of the table of tests.
    sha256 : str
        Hash of that file.
    """

    text: str = ""
    table: str = ""
    sha256: str = ""
