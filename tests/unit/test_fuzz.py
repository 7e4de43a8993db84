"""Five thousand inputs with something wrong, through every door: an answer or one sentence (``fuzz.py`` for more)."""

import pytest

from fuzz import SHARES, fuzz


@pytest.mark.slow
@pytest.mark.parametrize("door", SHARES)
def test_nothing_is_found(door: str) -> None:
    assert fuzz(SHARES[door] * 50, 10**7, door) == {}
