"""What verbs write and print of their answers: groups of options."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from narrows.cli.options import AsJson, DatasetOutput, ModelOutput, Plot, Report, TableOutput, TrackOutput
from narrows.cli.output import print_json, say_written

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Delivery:
    """Files that are asked for, and the form of the answer on the screen."""

    output: Path | None = None
    plot: Path | None = None
    report: Path | None = None
    json: bool = False

    def write(self, save: Callable[[Path], None], draw: Callable[[], "Figure"] | None = None) -> None:
        """Write the answer, and its picture, where they are asked for."""
        if self.output:
            save(self.output)
        if self.plot and draw:
            from narrows.files import save_figure

            save_figure(draw(), self.plot)

    def tell(self, values: Callable[[], Any], words: Callable[[], None]) -> None:
        """Print the answer, and what was written."""
        if self.json:
            print_json(values())
            return
        words()
        say_written((self.output, self.plot, self.report))


@dataclass(frozen=True)
class ModelDelivery(Delivery):
    """Of what is fitted."""

    output: ModelOutput = None
    report: Report = None
    json: AsJson = False


@dataclass(frozen=True)
class ReportDelivery(Delivery):
    """Of what is known of a model."""

    output: TableOutput = None
    report: Report = None
    json: AsJson = False


@dataclass(frozen=True)
class TableDelivery(Delivery):
    """Of a table."""

    output: TableOutput = None
    json: AsJson = False


@dataclass(frozen=True)
class TrackDelivery(Delivery):
    """Of a voyage."""

    output: TrackOutput = None
    plot: Plot = None
    json: AsJson = False


@dataclass(frozen=True)
class DatasetDelivery(Delivery):
    """Of what has several dimensions."""

    output: DatasetOutput = None
    plot: Plot = None
    json: AsJson = False
