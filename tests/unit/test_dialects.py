"""Tables just read: the same tests whatever parts cells and decimals, whatever stands above, in files and in memory."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import narrows as nw
from tables import frame_of, short_twin

ROWS = frame_of(short_twin()).iloc[::5].reset_index(drop=True)
DEGREES = ROWS.assign(psi=np.degrees(ROWS.psi))
UNITS = {"t": "s", "x": "m", "y": "m", "psi": "deg", "u": "m/s", "v": "m/s", "r": "rad/s", "udot": "m/s2",
         "vdot": "m/s2", "rdot": "rad/s2", "heave": "m", "X": "N", "Y": "N", "N": "Nm"}  # fmt: skip


def text(separator: str = ",", decimal: str = ".", frame: pd.DataFrame = ROWS) -> str:
    return frame.to_csv(index=False, sep=separator, decimal=decimal)


def units_under(separator: str, brackets: str = "{}") -> str:
    header, rows = text(separator, frame=DEGREES).split("\n", 1)
    units = separator.join(brackets.format(UNITS[name]) if name in UNITS else "" for name in DEGREES)
    return f"{header}\n{units}\n{rows}"


def headed(pattern: str) -> str:
    """Degrees in the header of the heading."""
    return text(frame=DEGREES).replace("psi", pattern, 1)


def with_remarks() -> str:
    lines = text().splitlines()
    return "\n".join(["# tank 3", "#", *lines[:4], "# carriage stopped", "", *lines[4:], "", ""])


def as_numpy_saves() -> str:
    lines = text(frame=ROWS.drop(columns="test"), separator=" ").splitlines()
    return "\n".join(["# " + lines[0], *lines[1:]])


DIALECTS: dict[str, str | bytes] = {
    "comma": text(),
    "semicolon": text(";"),
    "tab": text("\t"),
    "bar": text("|"),
    "semicolon, decimal comma": text(";", ","),
    "tab, decimal comma": text("\t", ","),
    "comma, quoted decimal comma": text(",", ","),
    "comma and blank": text().replace(",", ", "),
    "carriage returns": text(";").replace("\n", "\r\n").encode(),
    "UTF-8 with its mark": b"\xef\xbb\xbf" + text().encode(),
    "UTF-16": text(";", ",").encode("utf-16"),
    "Latin-1": text(frame=ROWS.assign(remark="Gerät 3")).encode("latin-1"),
    "comments": with_remarks(),
    "lines above": "HSVA\nTank 3; model 7\n\n" + text(";", ","),
    "cells above, as a workbook exports them": "HSVA" + ";" * 14 + "\nLpp;3,984" + ";" * 13 + "\n" + text(";", ","),
    "units under the header": units_under(";"),
    "units in brackets under the header": units_under("\t", "[{}]"),
    "units in parentheses under the header": units_under(",", "({})"),
    "psi (deg)": headed("psi (deg)"),
    "psi_deg": headed("psi_deg"),
    "psi [deg]": headed("psi [deg]"),
    "psi[°]": headed("psi[°]"),
    "minus signs of Unicode": text(";").replace("-", "\u2212"),
    "thousands in groups": text(";", frame=ROWS.assign(N=(ROWS.N * 1e3).map("{:,.12f}".format))).replace(
        "N\n", "N [mN m]\n", 1
    ),
    "carriage returns alone": text().replace("\n", "\r"),
    "commas at all ends": "\n".join(line + "," for line in text().splitlines()),
}


def same(found: nw.CaptiveTests, frame: pd.DataFrame = ROWS) -> None:
    order = np.argsort(pd.factorize(frame.test)[0], kind="stable")
    assert set(found.names) == set(frame.test)
    for name in ("t", "y", "psi", "u", "rdot", "heave", "X", "N"):
        np.testing.assert_allclose(found.columns[name], frame[name].to_numpy()[order], rtol=1e-12, atol=1e-12)


def put(folder: Path, content: str | bytes, name: str = "t.csv") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("case", DIALECTS)
def test_dialects(case: str, ship_file: Path, tmp_path: Path) -> None:
    same(nw.read_captive(put(tmp_path, DIALECTS[case]), ship_file))


@pytest.mark.parametrize(
    "case", ["semicolon, decimal comma", "comments", "UTF-16", "lines above", "carriage returns alone"]
)
def test_dialects_on_the_stream(case: str, ship_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", 100)
    path = put(tmp_path, DIALECTS[case])
    streamed, whole = nw.stream_captive(path, ship_file), nw.read_captive(path, ship_file)
    assert streamed.names == whole.names
    for block, other in zip(streamed.blocks(), [block.values for block in streamed.blocks()], strict=True):
        np.testing.assert_array_equal(block.values["Y"], other["Y"])
    streamed_y = np.concatenate([np.asarray(block.values["Y"]) for block in streamed.blocks()])
    np.testing.assert_array_equal(np.sort(streamed_y), np.sort(whole.columns["Y"]))


@pytest.mark.parametrize("day", ["2026-11-03", "2999-11-03"])  # The second is beyond 64 bits of nanoseconds
def test_dates_with_dots_begin_with_the_day(day: str, ship_file: Path, tmp_path: Path) -> None:
    start = pd.Timestamp(f"{day} 23:59:58")  # The day changes within the tests
    times = (start + pd.to_timedelta(ROWS.t, unit="s")).dt.strftime("%d.%m.%Y %H:%M:%S.%f")
    found = nw.read_captive(put(tmp_path, text(";", frame=ROWS.assign(t=times))), ship_file)
    same_test = np.concatenate([np.diff(run["t"]) for run in found])
    expected = np.concatenate([np.diff(part.t) for _, part in ROWS.groupby("test", sort=False)])
    np.testing.assert_allclose(same_test, expected, atol=2e-6)


def test_columns_parted_by_blanks_under_a_comment(ship_file: Path, tmp_path: Path) -> None:
    one = nw.read_captive(put(tmp_path, as_numpy_saves()[: as_numpy_saves().index("\n", 3000)], "t.txt"), ship_file)
    assert one.names == ("all",)
    np.testing.assert_allclose(one.columns["Y"], ROWS["Y"][: one.rows], rtol=1e-12)


def test_lines_that_are_passed_over_are_said(ship_file: Path, tmp_path: Path) -> None:
    found = nw.read_captive(put(tmp_path, DIALECTS["lines above"]), ship_file)
    assert "3 lines above the header were passed over" in found.notes


@pytest.mark.parametrize("case", ["comments", "lines above", "units under the header", "semicolon", "UTF-16"])
def test_sentences_count_the_lines_of_the_file(case: str, ship_file: Path, tmp_path: Path) -> None:
    content = DIALECTS[case]
    plain = content.decode("utf-16") if isinstance(content, bytes) else content
    lines = plain.splitlines()
    at = next(i for i in range(len(lines) - 10, len(lines)) if lines[i])
    cells = re.split("[;,\t]", lines[at]) if case == "comments" else lines[at].split(";")
    lines[at] = lines[at].replace(cells[5], "fast", 1)
    spoilt = "\n".join(lines)
    path = put(tmp_path, spoilt.encode("utf-16") if isinstance(content, bytes) else spoilt)
    with pytest.raises(nw.InputError, match=rf"t.csv: row {at + 1}, column 'u\S*.*' holds fast, not a finite number"):
        nw.read_captive(path, ship_file)


UNREADABLE: dict[str, tuple[str | bytes, str]] = {
    "no header": ("\n".join(text().splitlines()[1:]), r"seen 'column 1', 'column 2', .*--mapping"),
    "decimal and cell commas alike": (
        "t,u\n0,5,0,3\n0,6,0,3\n0,7,0,3\n", "row 2 has more cells than the header, 4 where 1 has 2; .*commas to either"
    ),
    "one column": ("depth\n1\n2\n", "no semicolon, tab, comma or bar parts the cells: line 1 reads 'depth'"),
    "foreign headers": (
        text(frame=ROWS.rename(columns=lambda name: f"q{name}")), "seen 'qtest', 'qt', 'qx', 'qy', 'qpsi', ...",
    ),
    "a workbook by another name": (b"PK\x03\x04\0\0\0\0", r"a ZIP archive, as workbooks are \(name it .xlsx\)"),
    "no numbers": ("t,u,v\na,b,c\nd,e,f\n", "row 2, column 't' holds a, not a finite number, and 1 more"),
    "a quote in the header that is never closed": (
        '"t,u,v\n1,2,3\n4,5,6\n', "no column is headed as a quantity: seen 'column 1'"
    ),
    "points and commas": (
        text(";", ",").replace(",", ".", 40),
        r"line \d+ holds '\S+,\S+' and line 2 '\S+' in one column; write all decimals with commas",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", UNREADABLE)
def test_what_cannot_be_read_says_what_was_seen(case: str, ship_file: Path, tmp_path: Path) -> None:
    content, said = UNREADABLE[case]
    with pytest.raises(nw.InputError, match=said) as error:
        nw.read_captive(put(tmp_path, content), ship_file)
    assert "is missing" not in str(error.value)


@pytest.mark.parametrize("block", [32_000, 40])
def test_a_quote_that_is_never_closed_is_placed(
    block: int, ship_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the file, after a comment, an empty line and a cell over two lines, whole or in blocks."""
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", block)
    rows = [f"{i},1.0,2.0,no\n" for i in range(100)]
    path = put(tmp_path, "".join(["t,u,v,remark\n", *rows, '# 5"\n', "\n", '100,1,2,"a\nb"\n', '101,"2,3,no\n']))
    for read in (nw.read_captive, lambda *given: list(nw.stream_captive(*given).blocks())):
        with pytest.raises(nw.InputError, match=r"t\.csv: row 106 opens a quote that no row closes; close it"):
            read(path, ship_file)


@pytest.mark.parametrize("block", [32_000, 40, 1])
def test_a_cell_in_quotes_goes_on_in_the_next_block(
    block: int, ship_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", block)
    rows = [f"{i},1.0,{2 + i}\n" for i in range(100)]
    rows[39] = '39,1.0,"\n41"\n'
    path = put(tmp_path, "".join(["t,u,v\n", *rows]))
    blocks = nw.stream_captive(path, ship_file).blocks()
    np.testing.assert_array_equal(np.concatenate([own.values["v"] for own in blocks]), np.arange(2.0, 102.0))


def test_a_line_of_words_above_others_is_no_header(ship_file: Path, tmp_path: Path) -> None:
    tests = nw.read_captive(put(tmp_path, "ship,kcs,x\n1,,\nt,u,v\n1,2,3\n2,3,4\n"), ship_file)
    np.testing.assert_array_equal(tests["u"], [2.0, 3.0])


def test_a_unit_of_another_quantity_in_a_selection_is_refused(ship_file: Path) -> None:
    with pytest.raises(
        nw.InputError, match="the DataFrame: column 'y_deg': deg is not a unit of this quantity; give it"
    ):
        nw.read_captive(ROWS, ship_file, where="y_deg > 1")


def test_excel(ship_file: Path, tmp_path: Path) -> None:
    path = tmp_path / "t.xlsx"
    with pd.ExcelWriter(path, engine="openpyxl") as book:
        ROWS.to_excel(book, sheet_name="runs", index=False)
        ROWS.iloc[:3].to_excel(book, sheet_name="other", index=False)
    found = nw.read_captive(path, ship_file)
    same(found)
    assert "sheet 'runs' is read, the first of 2" in found.notes


def test_excel_with_units_and_lines_above(ship_file: Path, tmp_path: Path) -> None:
    blank = [""] * (len(UNITS) - 1)
    cells = [["Tank 3", "", *blank], ["Lpp", 3.984, *blank], list(DEGREES), [UNITS.get(name, "") for name in DEGREES]]
    pd.DataFrame([*cells, *DEGREES.to_numpy().tolist()]).to_excel(tmp_path / "t.xlsx", header=False, index=False)
    same(nw.read_captive(tmp_path / "t.xlsx", ship_file))
    spoilt = DEGREES.astype({"u": object})
    spoilt.loc[4, "u"] = "fast"
    pd.DataFrame([*cells, *spoilt.to_numpy().tolist()]).to_excel(tmp_path / "t.xlsx", header=False, index=False)
    with pytest.raises(nw.InputError, match=r"t.xlsx: row 9, column 'u \[m/s\]' holds fast"):
        nw.read_captive(tmp_path / "t.xlsx", ship_file)


def polars_frame() -> object:
    return pytest.importorskip("polars").DataFrame({name: ROWS[name].to_list() for name in ROWS})


def dataset() -> xr.Dataset:
    made = xr.Dataset.from_dataframe(DEGREES.rename_axis("row"))
    made["psi"].attrs["units"] = "deg"
    return made.drop_vars("row")


def arrow_table() -> object:
    return pytest.importorskip("pyarrow").Table.from_pandas(ROWS)


IN_MEMORY: dict[str, Callable[[], object]] = {
    "pandas": lambda: ROWS,
    "pandas with an index": lambda: ROWS.set_index(["test", "t"]),
    "pandas, rows left out": lambda: pd.concat([ROWS, ROWS]).iloc[: len(ROWS)].set_index(np.arange(len(ROWS)) * 7),
    "polars": polars_frame,
    "arrow": arrow_table,
    "xarray": dataset,
    "a mapping of columns": lambda: {name: ROWS[name].to_numpy() for name in ROWS},
}


@pytest.mark.parametrize("case", IN_MEMORY)
def test_tables_in_memory(case: str, ship_file: Path) -> None:
    found = nw.read_captive(IN_MEMORY[case](), ship_file)
    same(found)
    assert len(found.source.sha256) == 64


def test_a_frame_is_not_changed_and_its_hash_is_of_its_cells(ship_file: Path) -> None:
    before = ROWS.copy()
    first, again = nw.read_captive(ROWS, ship_file).source, nw.read_captive(ROWS.copy(), ship_file).source
    pd.testing.assert_frame_equal(ROWS, before)
    assert first == again
    assert nw.read_captive(ROWS.assign(Y=ROWS.Y + 1e-9), ship_file).source.sha256 != first.sha256


def test_rows_of_a_frame_are_counted_from_nought(ship_file: Path) -> None:
    with pytest.raises(nw.InputError, match="the DataFrame: row 3, column 'u' is empty"):
        nw.read_captive(ROWS.assign(u=ROWS.u.where(ROWS.index != 3)), ship_file)


@pytest.mark.parametrize("table", [3, None, [1, 2], {"a": [1], "b": [1, 2]}], ids=["3", "None", "list", "uneven"])
def test_what_is_no_table(table: object, ship_file: Path) -> None:
    with pytest.raises(nw.InputError, match="give a"):
        nw.read_captive(table, ship_file)


PLAIN = {
    "abs(psi_deg) < 5": lambda f: f.psi.abs() < 5,
    "psi > 0.05": lambda f: np.radians(f.psi) > 0.05,
    "u_kn > 1.9 and test != 'sway'": lambda f: (f.u > 1.9 * 1852 / 3600) & (f.test != "sway"),
    "`psi (deg)` < 5": lambda f: f.psi < 5,
    "`psi (deg)` < 5 and abs(y) < 0.2": lambda f: (f.psi < 5) & (f.y.abs() < 0.2),
}


@pytest.mark.parametrize("where", PLAIN)
@pytest.mark.parametrize("read", [nw.read_captive, nw.stream_captive])
def test_selection_on_plain_names(read, where: str, ship_file: Path, tmp_path: Path) -> None:
    path = put(tmp_path, headed("psi (deg)"))
    rows = sum(block.rows for block in read(path, ship_file, where=where).blocks())
    assert 0 < rows == int(PLAIN[where](DEGREES).sum()) < len(DEGREES)


def test_selection_says_what_is_near(ship_file: Path, tmp_path: Path) -> None:
    with pytest.raises(nw.InputError, match="'speed' is not defined; it has "):
        nw.read_captive(put(tmp_path, text()), ship_file, where="speed > 1")
    with pytest.raises(nw.InputError, match="'hheave' is not defined; did you mean 'heave'"):
        nw.read_captive(put(tmp_path, text()), ship_file, where="hheave > 1")


def test_much_heave_is_noted_and_two_columns_of_one_name_are_refused(ship_file: Path) -> None:
    heave = np.full(len(ROWS), 0.3 * nw.read_ship(ship_file).ship.draft)
    assert (
        "Heave reaches 0.3 of the draft: check its unit." in nw.read_captive(ROWS.assign(heave=heave), ship_file).notes
    )
    with pytest.raises(nw.InputError, match="two columns are headed 'u'; keep one"):
        nw.read_captive(pd.concat([ROWS, ROWS[["u"]]], axis="columns"), ship_file)
