"""A model file gives back the same forces to the last bit, and the same everything else."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import STATES, numbers

import narrows as nw
from narrows.model.sections import to_toml

ANY = st.floats(allow_nan=False, allow_infinity=False)
"""Every finite double, subnormal ones too."""
COEFFICIENTS = st.fixed_dictionaries(dict.fromkeys(nw.PAPER.names, ANY))
SIZES = st.floats(1e-3, 1e3)
MEASURED = st.floats(-1e19, 1e19)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("model") / "model.toml"


def back(model: nw.Model, file: Path, terms: nw.TermTable | None = None) -> nw.Model:
    nw.save_model(model, file)
    return nw.load_model(file, terms)


@given(coefficients=COEFFICIENTS, seed=st.integers(0, 2**32))
def test_numbers_come_back_as_they_were(dtc: nw.Model, file: Path, coefficients: dict[str, float], seed: int) -> None:
    size = 10.0 ** np.arange(-9, 8)
    root = np.random.default_rng(seed).standard_normal((17, 30))
    covariance = np.cov(root) * np.outer(size, size)
    model = nw.Model(dtc.configuration, dtc.terms, coefficients, covariance)
    again = back(model, file)
    assert dict(again.coefficients) == coefficients
    assert again.covariance is not None
    np.testing.assert_array_equal(again.covariance, covariance)


@given(state=STATES, values=st.lists(numbers(-1e4, 1e4), min_size=17, max_size=17))
def test_forces_are_equal_to_the_last_bit(
    dtc: nw.Model, file: Path, state: dict[str, float], values: list[float]
) -> None:
    model = nw.Model(dtc.configuration, dtc.terms, dict(zip(dtc.terms.names, values, strict=True)))
    motion = nw.Motion.at(**state)
    assert back(model, file).forces(motion) == model.forces(motion)


@given(
    length=SIZES, beam=st.floats(0.01, 0.3), draft=st.floats(1e-3, 9e-3), block=st.floats(0.1, 1.0),
    density=st.floats(950, 1240), x_g=MEASURED,
)  # fmt: skip
def test_the_setting_comes_back(
    dtc: nw.Model, file: Path, length: float, beam: float, draft: float, block: float, density: float, x_g: float
) -> None:
    ship = nw.Ship(length, beam, draft, block, mass=length, inertia=density, x_g=x_g, name='a "ship" \\ é\n')
    configuration = nw.Configuration(ship, nw.Canal(7.0, draft * 1.5), nw.Water(density))
    assert back(nw.Model(configuration, dtc.terms, dtc.coefficients), file).configuration == configuration


def test_a_fit_comes_back(twin_fit: nw.Fit, file: Path) -> None:
    model, again = twin_fit.model, back(twin_fit.model, file)
    assert again.data_range == model.data_range
    assert again.source == model.source
    assert dict(again.coefficients) == dict(model.coefficients)
    assert again.terms is nw.PAPER
    np.testing.assert_array_equal(again.covariance, model.covariance)


def test_covariance_is_read_by_name_and_not_by_place(twin_fit: nw.Fit, file: Path) -> None:
    nw.save_model(twin_fit.model, file)
    tables = tomllib.loads(file.read_text())
    order = np.random.default_rng(0).permutation(17)
    matrix = np.array(tables["covariance"]["matrix"])[np.ix_(order, order)]
    tables["covariance"] = {"names": [tables["covariance"]["names"][i] for i in order], "matrix": matrix.tolist()}
    file.write_text(tomli_w.dumps(tables))
    np.testing.assert_array_equal(nw.load_model(file).covariance, twin_fit.model.covariance)


def test_saving_twice_writes_the_same_bytes(twin_fit: nw.Fit, tmp_path: Path) -> None:
    first, second = tmp_path / "a.toml", tmp_path / "b.toml"
    nw.save_model(twin_fit.model, first)
    nw.save_model(nw.load_model(first), second)
    assert first.read_bytes() == second.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.toml", "b.toml"]


def test_tapered_model_comes_back_tapered(dtc: nw.Model, file: Path) -> None:
    model = nw.Model(dtc.configuration, nw.TAPERED, dtc.coefficients)
    assert back(model, file).terms is nw.TAPERED


TOML_TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
TOML_VALUES = st.recursive(
    st.booleans() | st.integers() | st.floats(allow_nan=False) | TOML_TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TOML_TEXT, inner, max_size=3),
    max_leaves=12,
)


def lists_hold_tables(value: object) -> bool:
    if isinstance(value, dict):
        return any(map(lists_hold_tables, value.values()))
    return isinstance(value, list) and any(isinstance(one, dict) or lists_hold_tables(one) for one in value)


@given(table=st.dictionaries(TOML_TEXT, TOML_VALUES, max_size=4))
def test_tables_are_written_as_the_toml_reader_of_python_reads_them(table: dict[str, object]) -> None:
    assume(not lists_hold_tables(table))
    assert tomllib.loads(to_toml(table)) == table


def test_model_files_are_written_as_by_tomli_w(twin_fit: nw.Fit, dtc: nw.Model) -> None:
    for model in (twin_fit.model, dtc):
        assert to_toml(model.to_dict()) == tomli_w.dumps(model.to_dict())


def test_what_toml_cannot_hold_is_refused() -> None:
    with pytest.raises(TypeError, match="NoneType has no form in TOML"):
        to_toml({"nothing": None})
