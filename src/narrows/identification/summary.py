"""A fit as plain numbers and words, in the documented JSON shape."""

import math
from typing import TYPE_CHECKING, Any

from narrows.identification.diagnostics import Diagnosis
from narrows.identification.shapley import KINDS

if TYPE_CHECKING:
    from narrows.identification.fit import Fit


def finite(value: float) -> float | None:
    """Return a number as JSON can hold it: None for NaN and infinity (ours).

    Parameters
    ----------
    value : float
        Any.
    """
    return float(value) if math.isfinite(value) else None


def as_json(fit: "Fit") -> dict[str, Any]:
    """Return a fit in the documented JSON shape (ours).

    Parameters
    ----------
    fit : Fit
        The fit.
    """
    return {
        "coefficients": {name: _coefficient(fit, name) for name in fit.terms.names},
        "fit": {
            force: {
                "r2": finite(own.r2),
                "rmse": finite(own.rmse),
                "r2_left_out": finite(fit.left_out[force].r2),
                "rmse_left_out": finite(fit.left_out[force].rmse),
            }
            for force, own in fit.scores.items()
        },
        "diagnostics": {force: _diagnosis(found) for force, found in fit.diagnostics().items()},
        "by_speed": [
            {"speed": speed, "diagnostics": {force: _diagnosis(d) for force, d in found.items()}}
            for speed, found in fit.by_speed().items()
        ],
        "by_test": {
            test: {force: {name: finite(v) for name, v in d.vif.items()} for force, d in found.items()}
            for test, found in fit.by_test().items()
        },
        "shapley": {kind: fit.shapley(kind) for kind in KINDS},
        "kkt": {
            "satisfied": fit.kkt.satisfied,
            "stationarity": fit.kkt.stationarity,
            "multiplier": fit.kkt.multiplier,
        },
        "tradeoffs": [
            {"first": p.first, "second": p.second, "correlation": p.correlation, "slope": p.slope}
            for p in fit.tradeoffs
        ],
        "influence": {name: _influence(fit, name) for name in fit.terms.names},
        "split": fit.split,
        "notes": list(fit.notes),
    }


def _coefficient(fit: "Fit", name: str) -> dict[str, Any]:
    verdict = fit.verdicts[name]
    return {
        "value": fit.coefficients[name],
        "std": finite(fit.std[name]),
        "ci95": [finite(end) for end in fit.intervals[name]],
        "unit": fit.terms[name].dimension.unit,
        "identifiable": verdict.identifiable,
        "verdict": verdict.status,
        "confounded_with": list(verdict.partners),
        "reasons": list(verdict.reasons),
    }


def _influence(fit: "Fit", name: str) -> dict[str, Any]:
    """The test that a coefficient would miss most, and the one that moves it most."""
    (informing, share), (moving, by) = fit.influence.most_informing(name), fit.influence.most_moving(name)
    return {"most_informing": informing, "share": finite(share), "most_moving": moving, "moved_by": finite(by)}


def _diagnosis(found: Diagnosis) -> dict[str, Any]:
    return {
        "rank": found.rank,
        "columns": len(found.names),
        "condition": finite(found.condition),
        "vif": {name: finite(value) for name, value in found.vif.items()},
    }
