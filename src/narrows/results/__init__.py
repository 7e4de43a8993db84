"""What every result can do: say what it is, go into files, draw itself, answer to names of other libraries."""

from narrows.results.described import Described as Described
from narrows.results.described import shortened as shortened
from narrows.results.plain_values import plain as plain
from narrows.results.plain_values import to_json as to_json
from narrows.results.saving import save_dataset as save_dataset
from narrows.results.shown_results import Result as Result
from narrows.results.shown_results import Shown as Shown
from narrows.results.tabulated import Tabulated as Tabulated
