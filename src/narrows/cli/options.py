"""Arguments and options that verbs share."""

from pathlib import Path
from typing import Annotated

import typer

Table = Annotated[Path, typer.Argument(help="Captive tests: CSV, Parquet, .mat or .dat.", show_default=False)]
ShipFile = Annotated[Path, typer.Option("--ship", help="Ship file: TOML with [ship], [canal], [water].")]
ModelFile = Annotated[str, typer.Argument(help="Model file, or the name of a published model.", show_default=False)]
Duration = Annotated[float, typer.Option(help="Longest time of a voyage [s].")]
TimeStep = Annotated[float, typer.Option(help="Time step [s].")]
Surge = Annotated[str, typer.Option(help="'held': the speed stays; 'free': it is integrated.")]
SurgeInertia = Annotated[float | None, typer.Option(help="Mass in surge with its added mass [kg], for 'free'.")]
Coriolis = Annotated[bool, typer.Option("--coriolis", help="Add the rigid body's Coriolis force.")]
ContactKind = Annotated[
    str, typer.Option(help="What meets the bank: hull 'corners', 'midship' clearance, or 'none' in open water.")
]
TermsName = Annotated[str, typer.Option(help="Table of terms: 'paper', 'crossflow', 'mmg', 'paper+keel_gap+helm', ...")]
Where = Annotated[str | None, typer.Option(help="Rows to take, as in 'u > 0.3', on the table's headers.")]
Condition = Annotated[str | None, typer.Option(help="Take this condition of the table alone.")]
Report = Annotated[Path | None, typer.Option(help="Self-contained HTML report to write.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
