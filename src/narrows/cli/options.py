"""Arguments and options that verbs share."""

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
Duration = Annotated[
    float | None, typer.Option(help="Longest time of a voyage [s]; that of 15 ship lengths unless given.")
]
TimeStep = Annotated[
    float | None, typer.Option(help="Time step [s]; a 200th of the time of a ship length unless given.")
]
Surge = Annotated[str, typer.Option(help="'held': the speed stays; 'free': it is integrated.")]
SurgeInertia = Annotated[float | None, typer.Option(help="Mass in surge with its added mass [kg], for 'free'.")]
Coriolis = Annotated[bool, typer.Option("--coriolis", help="Add the rigid body's Coriolis force.")]
ContactKind = Annotated[
    str, typer.Option(help="What meets the bank: hull 'corners', 'midship' clearance, or 'none' in open water.")
]
WaterwayFile = Annotated[
    Path | None, typer.Option(help="GeoJSON to sail in instead of the model's canal; x, y, psi are to its line.")
]
Current = Annotated[str, typer.Option(help="Of the water along the waterway: 0.5m/s, 1kn.")]
Level = Annotated[float, typer.Option(help="Of the water over that of the waterway's depths [m].")]
TermsName = Annotated[str, typer.Option(help="Table of terms: 'paper', 'crossflow', 'mmg', 'paper+keel_gap+helm', ...")]
Where = Annotated[
    str | None, typer.Option(help="Rows to take, as in 'u > 0.3 and abs(psi_deg) < 9'; on its headers too.")
]
Mapping = Annotated[
    Path | None,
    typer.Option(help="TOML of the table's own names, units and signs: [columns], [units], [positive]."),
]
Plot = Annotated[Path | None, typer.Option(help="Picture to write: PNG, SVG or PDF.", callback=named(PICTURES))]
Condition = Annotated[str | None, typer.Option(help="Take this condition of the table alone.")]
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
