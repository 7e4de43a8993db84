"""Results: summary, files, plots, and names of other libraries."""

from narrows.results.saving import plain as plain
from narrows.results.saving import save_dataset as save_dataset
from narrows.results.saving import to_json as to_json
from narrows.results.shown_results import Described as Described
from narrows.results.shown_results import Result as Result
from narrows.results.shown_results import Shown as Shown
from narrows.results.shown_results import Tabulated as Tabulated
from narrows.results.shown_results import shortened as shortened
