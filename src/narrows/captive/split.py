"""Training and validation rows: the paper's seeded random split, for tests in memory or on disk."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from narrows.captive.tests import Block, CaptiveTests, Span, Tests
from narrows.errors import InputError
from narrows.model.sections import Source
from narrows.ship.particulars import Configuration


@dataclass(frozen=True)
class SomeRows:
    """A random part of the rows of some tests, the same at every pass."""

    tests: Tests  # All rows
    fraction: float  # Share of drawn rows [1]
    seed: int  # Seed of the draw
    drawn: bool  # True for the drawn part, false for the rest

    @property
    def configuration(self) -> Configuration:
        return self.tests.configuration

    @property
    def source(self) -> Source:
        return self.tests.source

    @property
    def notes(self) -> tuple[str, ...]:
        part = f"{self.fraction:.0%} of the rows, drawn at random with seed {self.seed}"
        return (*self.tests.notes, part if self.drawn else f"all but {part}")

    @property
    def names(self) -> tuple[str, ...]:
        return self.tests.names

    def blocks(self, pieces: int = 1) -> Iterator[Block]:
        draw = np.random.default_rng(self.seed)
        for block in self.tests.blocks(pieces):
            keep = (draw.random(block.rows) < self.fraction) == self.drawn
            if keep.any():
                yield _filtered(block, keep)


def _filtered(block: Block, keep: np.ndarray) -> Block:
    before = np.concatenate([[0], np.cumsum(keep)])
    spans = [Span(s.test, s.piece, int(before[s.start]), int(before[s.stop])) for s in block.spans]
    values = {name: v[keep] if np.ndim(v) else v for name, v in block.values.items()}
    return block._replace(values=values, rows=int(before[-1]), spans=[span for span in spans if span.stop > span.start])


def random_split(tests: Tests, fraction: float = 0.8, seed: int = 0) -> tuple[SomeRows, SomeRows]:
    """Split rows at random into those to fit and those to check, as the paper does."""
    # Neighbouring rows of one time series land on both sides, so the check is optimistic; leave whole tests out for a
    # fair one.
    if not 0 < fraction < 1:
        raise InputError(f"fraction {fraction} is not between 0 and 1; give the share of the rows to fit")
    if seed < 0:
        raise InputError(f"seed {seed} is negative; give 0 or more")
    return SomeRows(tests, fraction, seed, True), SomeRows(tests, fraction, seed, False)


def concat(tests: Sequence[CaptiveTests]) -> CaptiveTests:
    """Join tests of one ship in one water, in their order.

    Parameters
    ----------
    tests : sequence of CaptiveTests
        Only columns that all of them have are kept; tests that share a name are numbered.

    Returns
    -------
    CaptiveTests
        ``notes`` lists omitted columns and renamed tests.

    Raises
    ------
    InputError
        If there are none, or their ships, canals or waters differ.

    Examples
    --------
    >>> len(nw.concat([tests, tests])) == 2 * len(tests)
    True
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
    labels = tuple(label for part in parts for label in part.conditions or ("",) * len(part.names))
    names, renamed = _numbered([name for part in parts for name in part.names])
    return replace(
        first,
        columns={name: np.concatenate([part.columns[name] for part in parts]) for name in shared},
        names=names,
        starts=np.concatenate([[0], np.cumsum(np.concatenate([np.diff(part.starts) for part in parts]))]),
        conditions=labels if any(part.conditions for part in parts) else (),
        source=_source([part.source for part in parts]),
        notes=(*dict.fromkeys(note for part in parts for note in part.notes), *_notes(sorted(left), renamed)),
    )


def _numbered(names: list[str]) -> tuple[tuple[str, ...], list[str]]:
    """Return the names, numbered if they exist already; and the changed names."""
    taken, unique = set(names), list[str]()
    for name in names:
        own = name if name not in unique else next(it for n in count(2) if (it := f"{name} ({n})") not in taken)
        taken.add(own)
        unique.append(own)
    return tuple(unique), [name for name, times in Counter(names).items() if times > 1]


def _source(sources: list[Source]) -> Source:
    def joined(name: str) -> str:
        return " + ".join(dict.fromkeys(filter(None, (getattr(source, name) for source in sources))))

    return Source(joined("text"), joined("table"), joined("sha256"))


def _notes(left: list[str], renamed: list[str]) -> list[str]:
    notes = [f"Columns that not all tables have were left out: {', '.join(left)}."] if left else []
    return notes + ([f"Tests that share a name are numbered: {', '.join(renamed)}."] if renamed else [])
