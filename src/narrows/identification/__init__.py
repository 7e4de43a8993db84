"""Identification: rows to sums of products, sums to coefficients and to how far they can be trusted."""

from narrows.identification.conditions import identify_each as identify_each
from narrows.identification.fit import Fit as Fit
from narrows.identification.fit import identify as identify
