"""Arguments and options that verbs share."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from narrows.cli.output import DATASETS, MODELS, PAGES, TABLES, TRACKS, WATERWAYS, named
from narrows.files import PICTURES

Table = Annotated[
    Path, typer.Argument(help="Captive tests: CSV in any dialect, Parquet, Excel, .mat.", show_default=False)
]
ShipFile = Annotated[Path, typer.Option("--ship", help="Ship file: TOML with [ship], [canal], [water].")]
ModelFile = Annotated[str, typer.Argument(help="Model file, or the name of a published model.", show_default=False)]
WaterwayFile = Annotated[
    Path | None, typer.Option(help="GeoJSON to sail in instead of the model's canal; x, y, psi are to its line.")
]
TermsName = Annotated[str, typer.Option(help="Table of terms: 'paper', 'crossflow', 'mmg', 'paper+keel_gap+helm', ...")]
RunErrors = Annotated[str, typer.Option(help="What runs differ by: gain, zero and form, as shares of the force.")]
Plot = Annotated[Path | None, typer.Option(help="Picture to write: PNG, SVG or PDF.", callback=named(PICTURES))]
Report = Annotated[Path | None, typer.Option(help="Self-contained HTML report to write.", callback=named(PAGES))]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
ModelOutput = Annotated[
    Path | None, typer.Option("--output", "-o", help="Model file to write: .toml.", callback=named(MODELS))
]
DatasetOutput = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="Data: .nc, .zarr, .csv, .parquet, .mat or .json.", callback=named(DATASETS)),
]
TrackOutput = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="Voyage: .nc, .csv, .mat, ..., .geojson or .kml.", callback=named(TRACKS)),
]
TableOutput = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="Table to write: .csv, .parquet, .mat, .json.", callback=named(TABLES)),
]
WaterwayOutput = Annotated[
    Path | None, typer.Option("--output", "-o", help="GeoJSON to write.", callback=named(WATERWAYS))
]


@dataclass(frozen=True)
class SelectionOptions:
    """Which rows of a table, and what its columns are called."""

    where: Annotated[
        str | None, typer.Option(help="Rows to take, as in 'u > 0.3 and abs(psi_deg) < 9'; on its headers too.")
    ] = None
    mapping: Annotated[
        Path | None,
        typer.Option(help="TOML of the table's own names, units and signs: [columns], [units], [positive]."),
    ] = None
    condition: Annotated[str | None, typer.Option(help="Take this condition of the table alone.")] = None
