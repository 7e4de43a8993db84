"""Identification: rows to sums of products, sums to coefficients and to how far they can be trusted."""

from narrows.identification.fit import Fit as Fit
from narrows.identification.fitting import Comparison as Comparison
from narrows.identification.fitting import Explanation as Explanation
from narrows.identification.fitting import compare as compare
from narrows.identification.fitting import explain as explain
from narrows.identification.fitting import identify as identify
from narrows.identification.fitting import identify_conditions as identify_conditions
from narrows.identification.systematic_effects import RunErrors as RunErrors
