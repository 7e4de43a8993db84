"""Rows kept and rows left out: the paper's seeded random split, for tests in memory or on disk."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from narrows.captive.tests import Block, Span, Tests
from narrows.errors import InputError
from narrows.model.source import Source
from narrows.ship.particulars import Configuration


@dataclass(frozen=True)
class SomeRows:
    """A random part of the rows of some tests, the same at every pass."""

    tests: Tests  # All rows
    fraction: float  # Of the rows that are drawn [1]
    seed: int  # Of the draw
    drawn: bool  # Whether this is the part that was drawn, or the rest

    @property
    def configuration(self) -> Configuration:
        """Ship, canal and water."""
        return self.tests.configuration

    @property
    def source(self) -> Source:
        """Where the rows come from."""
        return self.tests.source

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader has to say."""
        part = f"{self.fraction:.0%} of the rows, drawn at random with seed {self.seed}"
        return (*self.tests.notes, part if self.drawn else f"all but {part}")

    @property
    def names(self) -> tuple[str, ...]:
        """The tests."""
        return self.tests.names

    def blocks(self, pieces: int = 1) -> Iterator[Block]:
        """Yield the rows of this part once, in blocks."""
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
    # Neighbouring rows of one time series land on both sides, so the check flatters: leave tests out instead where it
    # matters.
    if not 0 < fraction < 1:
        raise InputError(f"fraction {fraction} is not between 0 and 1; give the share of the rows to fit")
    if seed < 0:
        raise InputError(f"seed {seed} is negative; give 0 or more")
    return SomeRows(tests, fraction, seed, True), SomeRows(tests, fraction, seed, False)
