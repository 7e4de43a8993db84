"""tests/whole.txt names tests that exist."""


def test_each_pattern_matches_a_test(unmatched_patterns: set[str]) -> None:
    assert not unmatched_patterns
