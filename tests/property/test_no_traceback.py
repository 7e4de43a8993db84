"""Whatever stands in a header, a cell or a file: it reads, or it is refused in one sentence."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import narrows as nw
from narrows.captive.columns import COLUMNS
from narrows.model.sections import load_model
from narrows.readers.cells import parse_header
from nightly import draws
from tables import DTC_SHIP, frame_of, short_twin

CELLS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=6),
    st.dates(),
    st.sampled_from(["1,2", "0x1", "a\nb"]),
)
TOML = st.recursive(
    st.one_of(st.booleans(), st.integers(-9, 9), st.floats(), st.text(max_size=4)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text("ab", min_size=1), inner, max_size=2)),
    max_leaves=4,
)
SPELLED = "kmdegradsN°²³/*^.-+() 0123%[]'\"\\"


def refusal(call: Callable[[], object]) -> str:
    """Return what a call is refused with, nothing where it goes well; any other error goes on."""
    try:
        call()
    except nw.InputError as error:
        return str(error) or "nothing said\n"
    return ""


def one_line(sentence: str) -> bool:
    return len(sentence.splitlines()) <= 1


@given(name=st.sampled_from(sorted(COLUMNS)), unit=st.text(SPELLED, max_size=7))
@settings(max_examples=draws(100))
def test_units(name: str, unit: str) -> None:
    column = None

    def parse() -> None:
        nonlocal column
        column = parse_header(f"{name} [{unit}]", COLUMNS)

    assert one_line(refusal(parse))
    assert column is None or (column.quantity == name and column.stated)


@given(column=st.sampled_from([*sorted(COLUMNS), "test"]), row=st.integers(0, 40), cell=CELLS)
@settings(max_examples=draws(20))
def test_cells(tmp_path_factory: pytest.TempPathFactory, column: str, row: int, cell: object) -> None:
    frame = frame_of(short_twin()).iloc[:60]
    if column not in frame:
        frame = frame.assign(**{column: 7.0})
    frame = frame.astype({column: object})
    frame.iloc[row, frame.columns.get_loc(column)] = cell
    path = tmp_path_factory.mktemp("cells") / "t.csv"
    frame.to_csv(path, index=False)
    said = refusal(lambda: nw.identify(nw.read_captive(path, short_twin().configuration)))
    assert one_line(said)
    assert not said or "several conditions" in said or said.startswith(f"{path}: ")


def spoilt(text: str, section: str, key: str, value: object) -> dict:
    tables = tomllib.loads(text)
    if key:
        tables.setdefault(section, {})[key] = value
    else:
        tables[section] = value
    return tables


@given(
    section=st.sampled_from(["ship", "canal", "water", "depths"]),
    key=st.sampled_from(["", "length", "beam", "width", "depth", "density", "x_g", "mass", "A"]),
    value=TOML,
)
@settings(max_examples=draws(50))
def test_ship_files(tmp_path_factory: pytest.TempPathFactory, section: str, key: str, value: object) -> None:
    check_file(tmp_path_factory, nw.read_ship, spoilt(DTC_SHIP, section, key, value))


@given(
    section=st.sampled_from(["terms", "coefficients", "covariance", "data_range", "source", "ship"]),
    key=st.sampled_from(["", "table", "X", "b_v", "names", "matrix", "speed", "text", "beam"]),
    value=TOML,
)
@settings(max_examples=draws(50))
def test_model_files(
    dtc: nw.Model, tmp_path_factory: pytest.TempPathFactory, section: str, key: str, value: object
) -> None:
    path = tmp_path_factory.mktemp("model") / "m.toml"
    nw.save_model(dtc, path)
    check_file(tmp_path_factory, load_model, spoilt(path.read_text(), section, key, value))


def check_file(folders: pytest.TempPathFactory, read, tables: dict) -> None:
    import tomli_w

    path: Path = folders.mktemp("toml") / "t.toml"
    path.write_text(tomli_w.dumps(tables))
    said = refusal(lambda: read(path))
    assert one_line(said)
    assert not said or said.startswith(f"{path}: ")
