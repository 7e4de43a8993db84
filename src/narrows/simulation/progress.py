"""A bar for what takes long."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def bar(vessels: int, shown: bool) -> Iterator[Callable[[int], None]]:
    """Show how many voyages are done, if wanted (ours).

    Parameters
    ----------
    vessels : int
        In all.
    shown : bool
        Whether to.
    """
    if not shown:
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("voyages"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("voyages", total=vessels)
        yield lambda done: progress.advance(task, done)
