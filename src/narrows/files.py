"""Writing files whole or not at all."""

import os
import tempfile
from pathlib import Path

from narrows.errors import InputError


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file so that a reader finds the old one or the new one, never a part (ours).

    Parameters
    ----------
    path : str or Path
        Where to.
    content : str or bytes
        What; text as UTF-8.

    Raises
    ------
    InputError
        Where the folder is absent or closed.
    """
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        if temporary:
            Path(temporary).unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written ({error.strerror}); check the folder") from None
