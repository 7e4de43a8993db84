"""Tests of several tables as those of one."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import count

import numpy as np

from narrows.captive.tests import CaptiveTests
from narrows.errors import InputError
from narrows.model.source import Source


def concat(tests: Sequence[CaptiveTests]) -> CaptiveTests:
    """Put tests of one ship in one water together, in their order.

    Parameters
    ----------
    tests : sequence of CaptiveTests
        With the columns that all of them have; tests that share a name are numbered.

    Returns
    -------
    CaptiveTests
        What was left out or renamed stands in ``notes``.

    Raises
    ------
    InputError
        Where there are none, or their ships, canals or waters differ.
    """
    parts = list(tests)
    if not parts:
        raise InputError("there are no tests to put together; give two or more")
    first = parts[0]
    for part in parts:
        if part.configuration != first.configuration:
            raise InputError(f"{part!r} is of another ship or water than {first!r}; identify them one by one")
    shared = [name for name in first.columns if all(name in part.columns for part in parts)]
    left = {name for part in parts for name in part.columns} - set(shared)
    labelled = any(part.conditions for part in parts)
    names, renamed = _numbered([name for part in parts for name in part.names])
    return replace(
        first,
        columns={name: np.concatenate([part.columns[name] for part in parts]) for name in shared},
        names=names,
        starts=np.concatenate([[0], np.cumsum(np.concatenate([np.diff(part.starts) for part in parts]))]),
        conditions=tuple(label for part in parts for label in _labels(part)) if labelled else (),
        source=_source([part.source for part in parts]),
        notes=(*dict.fromkeys(note for part in parts for note in part.notes), *_notes(sorted(left), renamed)),
    )


def _numbered(names: list[str]) -> tuple[tuple[str, ...], list[str]]:
    """Names, those that were there before with a number; and the names that were."""
    taken, unique = set(names), list[str]()
    for name in names:
        own = name if name not in unique else next(it for n in count(2) if (it := f"{name} ({n})") not in taken)
        taken.add(own)
        unique.append(own)
    return tuple(unique), [name for name, times in Counter(names).items() if times > 1]


def _labels(part: CaptiveTests) -> tuple[str, ...]:
    return part.conditions or ("",) * len(part.names)


def _source(sources: list[Source]) -> Source:
    def joined(name: str) -> str:
        return " + ".join(dict.fromkeys(filter(None, (getattr(source, name) for source in sources))))

    return Source(joined("text"), joined("table"), joined("sha256"))


def _notes(left: list[str], renamed: list[str]) -> list[str]:
    notes = [f"Columns that not all tables have were left out: {', '.join(left)}."] if left else []
    return notes + ([f"Tests that share a name are numbered: {', '.join(renamed)}."] if renamed else [])
