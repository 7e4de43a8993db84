"""Revolutions that keep a speed: what a propeller turns at when nothing but the hull resists."""

import numpy as np
import xarray as xr

from narrows.errors import InputError
from narrows.model.model import Model


def self_propulsion(model: Model, u: float) -> float:
    """Return the revolutions at which thrust and resistance balance straight ahead, amidships [1/s].

    Parameters
    ----------
    model : Model
        With terms of a propeller.
    u : float [m/s]
        Surge velocity.

    Raises
    ------
    InputError
        Where the model has no propeller, or none is fast enough.
    """
    from scipy.optimize import brentq

    if not model.terms.propelled:
        raise InputError("this model has no terms of a propeller; there are no revolutions to look for")

    def surplus(revolutions: float) -> float:
        return -model.resistance(u, revolutions=revolutions)

    fast = next((n for n in 2.0 ** np.arange(-10, 20) if surplus(float(n)) > 0), None)
    if fast is None:
        raise InputError(f"no revolutions drive this ship at {u:g} m/s; check the propeller and the resistance")
    return float(brentq(surplus, 0.0, float(fast))) if surplus(0.0) < 0 else 0.0


def with_propulsion(model: Model, vary: dict[str, object]) -> dict[str, object]:
    """Return what varies, with revolutions that go with the speed where the terms ask for them."""
    if not model.terms.propelled or "revolutions" in vary:
        return vary
    speed = vary["u"]
    u = speed if isinstance(speed, xr.DataArray) else np.asarray(speed, float)
    revolutions = np.vectorize(lambda one_speed: self_propulsion(model, float(one_speed)), otypes=[float])(u)
    if isinstance(speed, xr.DataArray):
        return {**vary, "revolutions": speed.copy(data=revolutions)}
    column = xr.DataArray(revolutions, dims=["u"], coords={"u": u}) if revolutions.ndim else float(revolutions)
    return {**vary, "revolutions": column}
