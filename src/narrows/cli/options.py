"""Arguments and options of verbs, declared by annotation, ``Annotated[float, "..."]``; their output."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from importlib import import_module
from inspect import Parameter, signature
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import click
import numpy as np
from click.core import ParameterSource

from narrows.base.errors import InputError, shown
from narrows.base.files import PICTURES, form_of, is_stream, save_figure, to_json
from narrows.cli.app import app
from narrows.quantities.names import DEGREE, SPEED_UNITS

# Sizes of further units of a number, by the unit in the help of its option.
UNITS = {"s": {"s": 1.0, "min": 60.0, "h": 3600.0}, "deg": {"deg": 1.0, "rad": 1 / DEGREE}}


class Number(click.types.FloatParamType):
    """A number, also with the unit of its help or another one of that kind: 40m, 600s, 10min, 10deg."""

    def convert(self, value: Any, parameter: click.Parameter | None, context: click.Context | None) -> Any:
        unit = re.search(r"\[([^]\d][^]]*)\]", getattr(parameter, "help", None) or "")
        written = re.fullmatch(r"(.*[\d.])\s*([a-z].*)", str(value).strip().lower())
        sizes = UNITS.get(unit[1], {unit[1].lower(): 1.0}) if unit else {}
        size = sizes.get(written[2]) if written else None
        value = written[1] if written and size else value
        return super().convert(value, parameter, context) * (size or 1.0)


TYPES: dict[type, click.ParamType[Any, Any]] = {
    float: Number(), int: click.INT, str: click.STRING, Path: click.Path(path_type=Path),
}  # fmt: skip


class Text(click.ParamType[Any, Any]):
    """Reads a value from the name of its option and a text; a default is written as a user would."""

    name = "text"

    def __init__(self, read: Callable[[str, str], Any]) -> None:
        self.read = read

    def convert(self, value: Any, parameter: click.Parameter | None, context: click.Context | None) -> Any:
        return self.read(parameter.opts[0], value) if parameter and isinstance(value, str) else value


class Option:
    """An option of a verb; its name is that of the parameter unless names are given."""

    def __init__(self, *names: str, help: str, forms: tuple[str, ...] = (), **attributes: Any) -> None:
        self.names, self.attributes = names, {"help": help, **attributes}
        if forms:  # Another suffix of a file is refused before any computation
            self.attributes["callback"] = lambda context, parameter, path: path and form_of(path, forms) and path

    def parameter(self, name: str, kind: Any, default: Any) -> click.Parameter:
        """Return click's parameter: kind is the type, including a union with None or a list of many."""
        typed = {"is_flag": True} if kind is bool else _typed(kind, multiple=True)
        if default is Parameter.empty:
            typed["required"] = True
        else:
            typed |= {"default": default, "show_default": kind is not bool and default not in (None, "")}
        names = self.names or (f"--{name.replace('_', '-')}",)
        return click.Option([*names, name], **(typed | self.attributes))


class Argument(Option):
    """An argument of a verb, required unless it has a default."""

    def parameter(self, name: str, kind: Any, default: Any) -> click.Parameter:
        given = {} if default is Parameter.empty else {"default": default, "required": False}
        return click.Argument([name], **_typed(kind, nargs=-1), **given, **self.attributes)


def _typed(kind: Any, **of_many: Any) -> dict[str, Any]:
    """Return click's type of one value of ``X | None``, ``list[X]``, or ``Annotated[Any, read]``."""
    attributes: dict[str, Any] = {}
    while get_origin(kind) in (list, UnionType, Union):
        if get_origin(kind) is list:
            attributes = {**of_many, "callback": lambda context, parameter, values: list(values) or None}
        kind = next(part for part in get_args(kind) if part is not type(None))
    return {"type": TYPES[kind] if kind in TYPES else Text(get_args(kind)[1]), **attributes}


Function = Callable[..., None]


def verb(example: str, name: str | None = None, **together: Any) -> Callable[[Function], Function]:
    """Register a function as a verb, with rules on the options that go ``together``.

    A dataclass parameter becomes one option per field, a delivery some options.
    """

    def registered(function: Function) -> Function:
        parameters, groups = _declarations(function)

        def called(**given: Any) -> Any:
            check_together(click.get_current_context(), **together)
            made = {own: kind(**{each: given.pop(each) for each in names}) for own, (kind, names) in groups.items()}
            return function(**given, **made)

        own = name or function.__name__
        epilog = f"Example: {example}"
        app.add_command(click.Command(own, callback=called, params=parameters, help=function.__doc__, epilog=epilog))
        return function

    return registered


def _declarations(function: Callable[..., Any]) -> tuple[list[click.Parameter], dict[str, tuple[Any, list[str]]]]:
    """Return click's parameters of a function, and the dataclass and fields of each of its groups."""
    hints, parameters = get_type_hints(function, include_extras=True), list[click.Parameter]()
    groups: dict[str, tuple[Any, list[str]]] = {}
    for own, parameter in signature(function).parameters.items():
        kind, *chosen = get_args(hints[own]) if get_origin(hints[own]) is Annotated else (hints[own],)
        if not is_dataclass(kind):
            parameters.append(_declared(own, hints[own], parameter.default))
            continue
        kinds, made = get_type_hints(kind, include_extras=True), signature(kind).parameters  # type: ignore[arg-type]
        if chosen:
            kinds = {each: Annotated[kinds[each], option] for each, option in chosen[0].items()}
        groups[own] = kind, list(kinds)
        parameters += [_declared(each, hint, made[each].default) for each, hint in kinds.items()]
    return parameters, groups


def check_together(
    context: click.Context, needs: Mapping[str, str] | None = None, one: Sequence[str] = (), apart: Sequence[str] = ()
) -> None:
    """Check names with blanks between: each option needs one of some others; exactly, or at most, one of some."""
    words = {
        str(own.name): own.opts[0] if isinstance(own, click.Option) else own.make_metavar(context).strip("[].")
        for own in context.command.params
    }
    given = {
        name for name in words if context.params.get(name) is not None
        and context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    }  # fmt: skip
    for names, others in (needs or {}).items():
        for name in names.split():
            if name in given and not given.intersection(others.split()):
                needed = " or ".join(words[other] for other in others.split())
                raise InputError(f"{words[name]} goes with {needed}; add it, or leave {words[name]} out")
    for names in (*one, *apart):
        count, known = len(given.intersection(names.split())), ", ".join(words[name] for name in names.split())
        if count > 1 or (count == 0 and names in one):
            often = "exactly" if names in one else "at most"
            raise InputError(f"give {often} one of {known}; see {context.command_path} --help")


def _declared(name: str, hint: Any, default: Any) -> click.Parameter:
    assert get_origin(hint) is Annotated, f"the parameter {name} of a verb is declared by no Option or Argument"
    kind, *read, declaration = get_args(hint)
    option: Option = Option(help=declaration) if isinstance(declaration, str) else declaration
    return option.parameter(name, Annotated[(kind, *read)] if read else kind, default)


# Characters that a file name cannot hold, percent-encoded as in addresses.
NOT_IN_NAMES = str.maketrans({character: f"%{ord(character):02X}" for character in "/\\\0%"})
DATASETS = (".nc", ".csv", ".parquet", ".mat", ".json")
TRACKS = (*DATASETS, ".geojson")
TABLES = (".csv", ".parquet", ".mat", ".json")
# Suffixes of the verbs' files; the first is used for a device without one.
MODELS, PAGES, WATERWAYS = (".toml",), (".html", ".htm"), (".geojson", ".json")


def print_written(paths: Iterable[Path | None]) -> None:
    """Print which files were written; nothing for streams."""
    files = [path for path in paths if path is not None]
    for path in () if any(map(is_stream, files)) else files:
        click.echo(f"wrote {path}")


def folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made a folder ({error.strerror}); choose another") from None


def output_of(path: Path, label: str, conditions: int) -> Path:
    """Return the file of one of some conditions: its label is added to the name; a device is shared by all."""
    if conditions == 1 or is_stream(path):
        return path
    if not path.name:
        raise InputError(f"{path}: is a folder; name a file")
    return path.with_name(f"{path.stem}-{label.translate(NOT_IN_NAMES)}{path.suffix}")


Table = Annotated[Path, Argument(help="Captive tests: CSV in any dialect, Parquet, Excel.")]

SHIP_FILE = "Ship file (TOML): [ship] length, beam, draft, block_coefficient; [canal] width."
ShipFile = Annotated[Path | None, f"{SHIP_FILE} Not needed for the package's tests (kcs)."]
ModelFile = Annotated[str, Argument(help="Model file, or the name of a published model.")]

WaterwayFile = Annotated[Path | None, "GeoJSON of a waterway instead of the canal; x, y, psi are relative to its line."]


@dataclass(frozen=True)
class SelectionOptions:
    where: Annotated[str | None, "Selection of rows, as in 'u > 0.3 and abs(psi_deg) < 9', also by headers."] = None
    mapping: Annotated[Path | None, "TOML of own names, units and signs: [columns], [units], [positive]."] = None
    condition: Annotated[str | None, "Use only this condition of the table."] = None

    def mapping_of(self, table: Path) -> Path | None:
        """The mapping that was given, or else the confirmed columns.toml beside the table, if there is one."""
        from narrows.readers.mapping import CONFIRMED
        from narrows.ship.ship_file import load_toml

        path = table.with_name("columns.toml")
        confirmed = self.mapping is None and path.is_file() and load_toml(path).get(CONFIRMED) is True
        return path if confirmed else self.mapping


# Largest number of values in a range.
LARGEST_RANGE = 1_000_000
UNIT = re.compile(rf"(?:{'|'.join(sorted(filter(None, SPEED_UNITS), key=len, reverse=True))})?\s*$", re.IGNORECASE)


def numbers(option: str, text: str, such_as: str = "0.5, or 0.5,1,2, or -2.5:2.5:101 (from:to:count)") -> np.ndarray:
    """Read ``0.5``, ``0.5,1,2`` or ``from:to:count``."""
    try:
        if ":" in text:
            low, high, count = text.split(":")
            values = np.linspace(float(low), float(high), min(int(count), LARGEST_RANGE + 1))
        else:
            values = np.array([float(word) for word in text.split(",")])
    except (ValueError, OverflowError):
        raise InputError(f"{option} {shown(text)} is not understood; give {such_as}") from None
    if values.size > LARGEST_RANGE:
        raise InputError(f"{option} {shown(text)} has more than {LARGEST_RANGE} values; take fewer")
    if not values.size or not np.isfinite(values).all():
        raise InputError(f"{option} {shown(text)} must be finite numbers, at least one")
    return values


def speeds(option: str, text: str) -> np.ndarray:
    """Read speeds [m/s]: as numbers, all with a unit or all without: ``4.1m/s``, ``8kn,9kn``, ``4kn:12kn:17``."""
    between = ":" if ":" in text else ","
    words = text.split(between)
    carry = words[:2] if between == ":" else words
    written = [UNIT.search(word)[0].strip() for word in carry]  # type: ignore[index]
    units = {SPEED_UNITS[unit.lower()] for unit in written}
    if len(units) > 1 or len({not unit for unit in written}) > 1:
        raise InputError(
            f"{option} {shown(text)} has several units, or numbers without; give each number the same unit"
        )
    bare = [word.strip().removesuffix(unit).strip() for word, unit in zip(carry, written, strict=True)]
    plain = between.join(bare + words[len(carry) :])
    return numbers(option, plain, "4.1m/s, 8kn, or 8kn,9kn, or 4kn:12kn:17 (from:to:count)") * units.pop()


def speed(option: str, text: str) -> float:
    values = speeds(option, text)
    if values.size != 1:
        raise InputError(f"{option} {shown(text)} is more than one speed; give one, as 4.1m/s or 8kn")
    return float(values[0])


def words(_: str, text: str) -> tuple[str, ...]:
    """Read ``a,b,c``; nothing of an empty text."""
    return tuple(filter(None, map(str.strip, text.split(","))))


def _read_by(module: str, name: str) -> Callable[[str, str], Any]:
    return lambda _, text: getattr(import_module(module), name)(text)  # Imported when it is needed


# Types of options that are read from text.
Numbers = Annotated[Any, numbers]
Speed = Annotated[Any, speed]
Speeds = Annotated[Any, speeds]
Words = Annotated[Any, words]
Terms = Annotated[
    Any,
    _read_by("narrows.model.tables", "table_named"),
    "Table of terms: 'paper', 'crossflow', 'mmg', 'paper+keel_gap+helm', ...",
]
RunErrors = Annotated[
    Any,
    _read_by("narrows.identification.systematic_effects", "run_errors_of"),
    Option("--run-errors", help="Differences between runs: gain, zero and form, as shares of the force."),
]


@dataclass(frozen=True)
class Delivery:
    output: Path | None = None
    json: bool = False
    plot: Path | None = None
    report: Path | None = None

    def give(
        self, result: Any, words: Callable[[Any], object], *, save: Callable[[Path], Any] | None = None,
        draw: Callable[[], Any] | None = None, report: Callable[[Path], None] | None = None,
        values: Callable[[], Any] | None = None,
    ) -> None:  # fmt: skip
        """Write the files of a result, and print it in ``words``, or as JSON of ``values`` (its ``to_dict``)."""
        if self.output:
            (save or result.save)(self.output)
        if self.report and report:
            report(self.report)
        if self.plot:
            save_figure((draw or result.plot)(), self.plot)
        self.show(values or result.to_dict, lambda: words(result))

    def show(self, values: Callable[[], Any], words: Callable[[], object]) -> None:
        if self.json:
            click.echo(to_json(values()))
        else:
            words()
            print_written((self.output, self.plot, self.report))


JSON = Option("--json", help="Print JSON instead of tables.")
AsJson = Annotated[bool, JSON]
PICTURE = Option(help="Picture to write: PNG, SVG or PDF.", forms=PICTURES)
REPORT = Option(help="Self-contained HTML report to write.", forms=PAGES)


def delivered(help: str, forms: tuple[str, ...], **others: Option) -> dict[str, Option]:
    """Return the options of a delivery: by default its file and its JSON."""
    return {"output": Option("--output", "-o", help=help, forms=forms), "json": JSON, **others}


PlainModelDelivery = Annotated[Delivery, delivered("Model file to write: .toml.", MODELS)]
ModelDelivery = Annotated[Delivery, delivered("Model file to write: .toml.", MODELS, report=REPORT)]
TABLE = "Table to write: .csv, .parquet, .mat, .json."
TableDelivery = Annotated[Delivery, delivered(TABLE, TABLES)]
ReportDelivery = Annotated[Delivery, delivered(TABLE, TABLES, report=REPORT)]
ChartDelivery = Annotated[Delivery, delivered(TABLE, TABLES, plot=PICTURE)]
TrackDelivery = Annotated[Delivery, delivered("Voyage: .nc, .csv, .mat, ..., .geojson.", TRACKS, plot=PICTURE)]
DatasetDelivery = Annotated[Delivery, delivered("Data: .nc, .csv, .mat, ..., .json.", DATASETS, plot=PICTURE)]
WaterwayDelivery = Annotated[Delivery, delivered("GeoJSON to write.", WATERWAYS)]
