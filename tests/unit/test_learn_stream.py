"""A log larger than memory: records are read when their turn comes and let go, and a bar says how far."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from weakref import WeakSet

import pytest
from test_learn import errs, manoeuvred, mistaken

import narrows as nw
from narrows.logbook.filtering import likelihood

TOLD = {"sensors": "basin", "spread": errs("N_v", "N_r"), "free": ("N_v", "N_r")}
COUNT = 4


class Stream:
    """Records that are made anew whenever the log is gone through, as those of a file are."""

    def __init__(self) -> None:
        self.alive: WeakSet[nw.ShipRecord] = WeakSet()
        self.most = 0

    def __iter__(self) -> Iterator[nw.ShipRecord]:
        for number in range(COUNT):
            record = manoeuvred(number % 2, 0.35 * (-1) ** number)
            told = {name: nw.Signal(own.t.copy(), own.values.copy()) for name, own in record.signals.items()}
            made = nw.ShipRecord(f"{number}", told).between(0.0, 100.0)
            self.alive.add(made)
            self.most = max(self.most, len(self.alive))
            yield made
            del made


@pytest.mark.slow
def test_records_of_a_stream_are_let_go_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """At most the one at hand, the one laid out before it and the one that comes are there at once."""
    stream, bars = Stream(), list[list[int]]()

    @contextmanager
    def counted(total: int, shown: bool, what: str) -> Iterator[Callable[[int], None]]:
        bars.append([total])
        yield bars[-1].append

    monkeypatch.setattr(likelihood, "bar", counted)
    assert len(nw.learn(mistaken(), stream, **TOLD).records) == COUNT
    assert stream.most <= 3
    # A stream is counted when it is first gone through.
    assert all(sum(done) == COUNT for _, *done in bars)
    assert [total for total, *_ in bars] == [0] + [COUNT] * (len(bars) - 1)
