"""What steady legs teach: the update by the balance beside a search over every unknown, which asks for steady courses.

python benchmarks/steady.py [LEGS] [--small]

Both give the same most likely coefficients. The search has coefficients, wind, zeros, and where the ship was on each
leg free, and asks for the steady course of each trial; it knows nothing of the balance's slopes.
"""

from dataclasses import replace

import numpy as np
import xarray as xr
from common import interleaved, show, sizes
from scipy.optimize import least_squares

import narrows as nw
from narrows.identification.fitting import bundled_ship
from narrows.logbook.steady_readings import reading_error, shared_errors

LENGTH, WIDTH, SPEED, OFFSET = 399.94, 205.0, 4.1, 5.0
CONDITIONS = nw.SteadyConditions(wind_change=0.0, yaw_rate_deg=0.0, yaw_change_deg=0.0, sway_change=0.0)
FREE = ("b_bank", "c_bank", "b_ur", "c_ur", "b_uv", "c_uv", "b_helm", "c_helm")


def ship() -> nw.Model:
    """The KCS at 50 % clearance and at full size, of whose covariance some coefficients are free."""
    model = bundled_ship(LENGTH, WIDTH)
    free = np.array([name in FREE for name in model.terms.names])
    return replace(model, covariance=model.covariance * np.outer(free, free))


def read(model: nw.Model, legs: int) -> dict[str, np.ndarray]:
    """Legs in turn to either side, with errors."""
    draw = np.random.default_rng(1)
    y, u = OFFSET * np.where(np.arange(legs) % 2, -1.0, 1.0), np.full(legs, SPEED)
    held = courses(model, y, u)
    true = {"y": y, "u": u, "rudder": held[:, 0], "drift": held[:, 1]}
    noisy = {
        name: column + reading_error(nw.SteadyConditions(), name) * draw.standard_normal(legs)
        for name, column in true.items()
    }
    return {**noisy, "heave": np.zeros(legs)}


def courses(model: nw.Model, y: np.ndarray, u: np.ndarray, **push: float) -> np.ndarray:
    """Rudder and heading that hold the ship on legs."""
    at = {name: xr.DataArray(column, dims="leg") for name, column in (("y", y), ("u", u))}
    held = nw.steady_course(model, workers=1, **at, **push)
    return np.stack([held["rudder"], held["psi"]], axis=1)


def searched(model: nw.Model, legs: dict[str, np.ndarray]) -> np.ndarray:
    """The most likely coefficients, all unknowns free."""
    index = [model.terms.names.index(name) for name in FREE]
    root = np.linalg.cholesky(model.covariance[np.ix_(index, index)])
    mean, shared = np.array([model[name] for name in FREE]), shared_errors(CONDITIONS, model)
    error = {name: reading_error(nw.SteadyConditions(), name) for name in ("y", "u", "rudder", "drift")}

    def misfit(x: np.ndarray) -> np.ndarray:
        theta, common, place = np.split(x, [len(FREE), len(FREE) + len(shared)])
        truth = model.with_coefficients(**dict(zip(FREE, (mean + root @ theta).tolist(), strict=True)))
        (east, turn, rudder, drift, aside), (y, u) = shared * common, place.reshape(2, -1)
        held = courses(truth, legs["y"] + error["y"] * y - aside, legs["u"] + error["u"] * u, Y=east, N=turn)
        off = (
            (legs["rudder"] - rudder - held[:, 0]) / error["rudder"],
            (legs["drift"] - drift - held[:, 1]) / error["drift"],
        )
        return np.concatenate([x, *off])

    best = least_squares(misfit, np.zeros(len(FREE) + len(shared) + 2 * len(legs["y"])))
    return mean + root @ best.x[: len(FREE)]


def main() -> None:
    """Time both."""
    count, _ = sizes(__doc__, 4, 2)
    model = ship()
    legs = read(model, count)
    found: dict[str, np.ndarray] = {}

    def updated() -> None:
        fit = nw.learn_steady(model, legs, conditions=CONDITIONS)
        found["updated"] = np.array([fit.coefficients[name].value for name in FREE])

    def sought() -> None:
        found["searched"] = searched(model, legs)

    times = interleaved({"update by the balance": updated, "search over every unknown": sought}, 3)
    std = np.sqrt(np.diag(model.covariance))[[model.terms.names.index(name) for name in FREE]]
    apart = float(np.abs((found["updated"] - found["searched"]) / std).max())
    rows = [(name, seconds, f"{apart:.1g} standard errors apart") for name, seconds in times.items()]
    show(f"{count} steady legs of a 400 m ship", rows, "ms", 1e3)


if __name__ == "__main__":
    main()
