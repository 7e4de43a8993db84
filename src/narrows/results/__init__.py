"""Results: summary, files, plots, and names of other libraries."""

from narrows.results.base_results import Aliased as Aliased
from narrows.results.base_results import BaseResult as BaseResult
from narrows.results.base_results import BaseSummary as BaseSummary
from narrows.results.base_results import Named as Named
from narrows.results.base_results import Tabulated as Tabulated
from narrows.results.base_results import same_content as same_content
from narrows.results.base_results import shortened as shortened
from narrows.results.saving import plain as plain
from narrows.results.saving import save_dataset as save_dataset
from narrows.results.saving import to_json as to_json
