"""What a thing says of itself."""

from html import escape
from typing import TYPE_CHECKING, Any

from narrows.results.elsewhere import answer


class Described:
    """Something that says in a line what it is, in a notebook in more, and answers to names of elsewhere.

    It has ``summary()``; ``to_dataframe()`` and ``notes`` where there is something to put there.
    """

    def __repr__(self) -> str:
        said: Any = self
        return f"<{type(self).__name__}: {shortened(said.summary())}>"

    def _repr_html_(self) -> str:
        said: Any = self
        lines = "<br>".join(escape(line) for line in said.summary().splitlines())
        notes = "".join(f"<li>{escape(note)}</li>" for note in getattr(said, "notes", ()))
        table = said.to_dataframe().to_html(max_rows=30) if hasattr(said, "to_dataframe") else ""
        return f"<p>{lines}</p>{table}" + (f"<ul>{notes}</ul>" if notes else "")

    if not TYPE_CHECKING:  # What is checked is the attributes that there are.

        def __getattr__(self, name: str) -> Any:
            return answer(self, name)


def shortened(text: str, most: int = 120) -> str:
    """Return the first line of a text, cut where it is long.

    Parameters
    ----------
    text : str
        Lines.
    most : int
        Characters of it.
    """
    line = text.partition("\n")[0].rstrip(".")
    return line if len(line) <= most else f"{line[: most - 3]}..."
