"""Identification: rows to sums of products, sums to coefficients and to how far they can be trusted."""

from narrows.identify.conditions import identify_each as identify_each
from narrows.identify.fit import Fit as Fit
from narrows.identify.fit import identify as identify
