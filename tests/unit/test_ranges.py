"""Numbers, ranges and speeds as they are typed."""

import numpy as np
import pytest

import narrows as nw
from narrows.cli.options import numbers, speed, speeds

KNOT = 1852 / 3600


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1.2", [1.2]),
        ("1.2m/s", [1.2]),
        ("8kn", [8 * KNOT]),
        ("8 kn", [8 * KNOT]),
        ("36km/h", [10.0]),
        ("8kn,9.5kn", [8 * KNOT, 9.5 * KNOT]),
        ("4kn:12kn:3", [4 * KNOT, 8 * KNOT, 12 * KNOT]),
        ("0.6:1.2:3", [0.6, 0.9, 1.2]),
        ("1e-1m/s", [0.1]),
        ("-2kn", [-2 * KNOT]),
    ],
)
def test_speeds(text: str, expected: list[float]) -> None:
    np.testing.assert_allclose(speeds("--speed", text), expected, rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("8mph", "is not understood; give 4.1m/s, 8kn"),
        ("fast", "is not understood"),
        ("", "is not understood"),
        ("kn", "is not understood"),
        ("8kn8kn", "is not understood"),
        ("8kn,9", "has several units, or numbers without; give each number the same unit"),
        ("8,9kn", "has several units"),
        ("4:12kn:17", "has several units"),
        ("4kn:12kn:17kn", "is not understood"),
        ("4kn:12m/s:17", "has several units"),
        ("4kn:12kn:0", "at least one"),
        ("nan", "must be finite"),
        ("infkn", "must be finite"),
    ],
)
def test_what_is_no_speed(text: str, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        speeds("--speed", text)


def test_one_speed_is_one() -> None:
    assert speed("--speed", "8kn") == 8 * KNOT
    with pytest.raises(nw.InputError, match="is more than one speed; give one, as"):
        speed("--speed", "8kn,9kn")


def test_numbers() -> None:
    np.testing.assert_array_equal(numbers("--y", "-2:2:5"), [-2, -1, 0, 1, 2])
    with pytest.raises(nw.InputError, match="--y '1;2' is not understood; give"):
        numbers("--y", "1;2")


def test_a_unit_reaches_the_voyage(cli) -> None:
    """The same speed in two units grounds at the same place."""
    said = [cli("simulate", "mikkelsen2025_dtc", "--y", 0.5, "--speed", text)[1] for text in ("1", "1m/s", "3.6km/h")]
    assert len(set(said)) == 1
    assert said[0].startswith("Grounded to port")
    assert cli("simulate", "mikkelsen2025_dtc", "--y", 0.5, "--speed", "1kn")[1] != said[0]
