"""The matrix: voyages, fleets and the reference agree; mirrored to the bit; bit-equal for any number of workers."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from cases import Case, axes_of, matrix, mirrored, waterway_for
from laws import mirrored_law
from public import fleet, kinds, sides, voyage
from reference import End

import narrows as nw
from narrows.simulation import kernel_run
from narrows.simulation.controllers import CONTROLLERS
from pairwise import pairs_of, pairwise_cover


def pairs_that_meet(axes: tuple[str, ...]) -> set[tuple]:
    """Pairs of ship, course, surge and controller; of a contact only with the course, whose banks it meets."""
    return pairs_of(axes[:4]) | pairs_of((axes[1], axes[4]))


CELLS = list(matrix())
# Each cell compiles a kernel of its own, so that all take most of an hour: the other tests run with a cover by pairs,
# ``make test-whole`` with every cell.
USUAL = [Case(*axes) for axes in pairwise_cover(map(axes_of, CELLS), pairs_that_meet)]
CASES = [pytest.param(case, marks=() if case in USUAL else pytest.mark.whole) for case in CELLS]
TRACKS = list(dict.fromkeys((case.ship, case.course, case.surge, case.controller) for case in CELLS))
ENDS = ("y_end", "psi_end", "u_end", "v_end", "r_end")
MIRRORED = ("y", "psi", "v", "r", "rudder", "Y", "N")
TIME, TRACK = 1e-6, 1e-9
VESSELS = 64


def in_every_cell(test: Callable[..., None]) -> Callable[..., None]:
    """Hold the engine to a test in every cell of the matrix."""
    return pytest.mark.parametrize("case", CASES, ids=str, scope="module")(test)  # cell by cell: a kernel at a time


def start_of(case: Case) -> int:
    """Which start the reference sails: another from track to track, one for all contacts on a track."""
    return TRACKS.index((case.ship, case.course, case.surge, case.controller)) % len(case.starts["y"])


@lru_cache(4)
def together(case: Case) -> xr.Dataset:
    """Every start of a cell, sailed once for all tests."""
    return fleet(case)


@lru_cache(16)
def alone(case: Case, number: int) -> nw.Voyage:
    """One start by itself, sailed once."""
    return voyage(case, number)


@cache
def expected(case: Case) -> End:
    return case.reference(start_of(case)).end(case.shape)


@in_every_cell
def test_a_voyage_is_the_reference(case: Case) -> None:
    found, reference = alone(case, start_of(case)).outcome, expected(case)
    assert (found.kind, found.side) == (reference.kind, reference.side)
    assert found.time == pytest.approx(reference.time, abs=TIME)
    far = 5 if case.contact == "midship" else 2  # which is met at a speed without bound
    assert found.distance == pytest.approx(reference.distance, abs=far * TIME)


@in_every_cell
def test_a_fleet_is_the_reference(case: Case) -> None:
    ended, number, reference = together(case), start_of(case), expected(case)
    assert (kinds(ended)[number], sides(ended)[number]) == (reference.kind, reference.side)
    assert ended["time"].to_numpy().ravel()[number] == pytest.approx(reference.time, abs=TIME)


@in_every_cell
def test_a_fleet_is_its_voyages(case: Case) -> None:
    ended = together(case)
    singles = [alone(case, number).outcome for number in range(len(case.starts["y"]))]
    assert kinds(ended) == [one.kind for one in singles]
    assert sides(ended) == [one.side for one in singles]
    near = {"rtol": 0.0, "atol": TRACK}
    np.testing.assert_allclose(ended["time"], [one.time for one in singles], **near)
    for name in ENDS if case.contact != "midship" else ("y_end",):
        np.testing.assert_allclose(ended[name], [one.state[name.removesuffix("_end")] for one in singles], **near)


def reflection(case: Case) -> dict[str, Any]:
    """What a fleet is told in the mirror."""
    starts = {name: xr.DataArray(column, dims="start") for name, column in case.starts.items()}
    told = {name: -value for name, value in {**starts, **case.push}.items() if name in MIRRORED}
    way = None if case.waterway is None else waterway_for(case.ship, mirrored=True)
    shape = case.shape if isinstance(case.shape, str) else [(f, -s) for f, s in case.shape]
    return {**told, "waterway": way, "contact": shape, "controller": mirrored_law(case.law)}


@in_every_cell
def test_mirrored_to_the_bit(case: Case) -> None:
    other = replace(case)
    object.__setattr__(other, "model", mirrored(case.model))
    plain, reflected = together(case), fleet(other, **reflection(case))
    for name in ("outcome", "time", "distance", "u_end"):
        np.testing.assert_array_equal(plain[name], reflected[name])
    for name in ("side", "y_end", "psi_end", "v_end", "r_end"):
        np.testing.assert_array_equal(plain[name], -reflected[name])


@in_every_cell
def test_a_mirrored_voyage_to_the_bit(case: Case) -> None:
    other, number = replace(case), start_of(case)
    object.__setattr__(other, "model", mirrored(case.model))
    told = {name: v[number].item() if isinstance(v, xr.DataArray) else v for name, v in reflection(case).items()}
    plain, reflected = alone(case, number), voyage(other, number, **told)
    assert plain.outcome.kind == reflected.outcome.kind
    assert plain.outcome.time == reflected.outcome.time
    for name in ("t", "x", "u"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(reflected, name))
    for name in ("y", "psi", "v", "r", "rudder"):
        np.testing.assert_array_equal(getattr(plain, name), -getattr(reflected, name))


def crowd(case: Case) -> dict[str, Any]:
    """Many starts about those of a case."""
    draw = np.random.default_rng(3)
    columns = {name: np.resize(column, VESSELS) for name, column in case.starts.items()}
    columns["psi"] = columns["psi"] + 0.02 * draw.standard_normal(VESSELS)
    return {name: xr.DataArray(column, dims="start") for name, column in columns.items()}


@in_every_cell
def test_the_number_of_workers_changes_no_bit(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_run, "SMALLEST_SLICE", 8)  # Or so few vessels would all be one worker's
    crew = crowd(case)
    one, *others = (fleet(case, **crew, workers=workers) for workers in (1, 2, 3))
    assert one.sizes["start"] == VESSELS
    for other in others:
        xr.testing.assert_identical(one, other)


@in_every_cell
def test_a_vessel_does_not_depend_on_its_company(case: Case) -> None:
    crew = crowd(case)
    whole = fleet(case, **crew)
    part = fleet(case, **{name: column[7:18] for name, column in crew.items()})
    for name in whole.data_vars:
        np.testing.assert_array_equal(whole[name].isel(start=slice(7, 18)), part[name])


def test_the_matrix_is_whole() -> None:
    """A hull without a rudder takes no controller; nothing else is left out."""
    count = Counter((case.ship, case.course, case.contact) for case in CELLS)
    assert len(CELLS) == 16 + 32 * len(CONTROLLERS)
    assert set(count.values()) == {2, 2 * len(CONTROLLERS)}


def test_what_runs_with_the_other_tests_holds_every_pair() -> None:
    """Among them every controller under each ship that steers, and in bends."""
    covered = set().union(*(pairs_that_meet(axes_of(case)) for case in USUAL))
    assert covered == set().union(*(pairs_that_meet(axes_of(case)) for case in CELLS))
    steered = {(case.ship, case.controller) for case in USUAL if case.law}
    assert steered == {(ship, name) for ship in ("steered", "mmg+delta") for name in CONTROLLERS}
    assert len(USUAL) < 4 + 2 * len(CONTROLLERS)


def test_the_matrix_meets_every_end() -> None:
    """Or it would not hold the engine to them."""
    ends, least = Counter((end.kind, end.side) for end in map(expected, USUAL)), len(USUAL) // 15
    assert ends["grounded", "starboard"] > least
    assert ends["grounded", "port"] > least
    assert ends["afloat", None] > least


def test_the_cells_are_told_apart() -> None:
    """A hull that ended as another does would hold nothing."""
    cells = [Case("paper", "straight", "held", "constant", contact) for contact in ("corners", "outline", "midship")]
    corners, outline, midship = (cell.reference(start_of(cell)).end(cell.shape).time for cell in cells)
    assert corners < outline < midship
