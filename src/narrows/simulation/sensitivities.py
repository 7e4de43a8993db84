"""How a voyage moves with its start, its coefficients and its inputs: the exact tangent of every step that it took."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.results import Shown
from narrows.simulation.tangent_march import TangentMarch
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    import xarray

STATES = {"x": "m", "y": "m", "psi": "rad", "u": "m/s", "v": "m/s", "r": "rad/s"}


@dataclass(frozen=True, repr=False, eq=False)
class Sensitivities(Shown):
    """A voyage with the derivatives of its state, exact for the steps that it took.

    Parameters
    ----------
    voyage : Voyage
        What was sailed.
    by : tuple of str
        What the state is differentiated by.
    slopes : array (times, 6, by)
        Of x, y [m], psi [rad], u, v [m/s] and r [rad/s], each over the SI unit of what it is differentiated by.
    values : mapping of str to float
        What those are in the voyage.
    model : Model
        The ship.
    """

    voyage: Voyage
    by: tuple[str, ...]
    slopes: np.ndarray
    values: Mapping[str, float]
    model: Model

    def __repr__(self) -> str:
        return f"<Sensitivities of {self.voyage!r} by {len(self.by)} numbers>"

    @property
    def notes(self) -> tuple[str, ...]:
        """What the voyage says beside how it ended."""
        return self.voyage.notes

    def of(self, state: str, by: str) -> np.ndarray:
        """Return one derivative, (times,).

        Parameters
        ----------
        state : {"x", "y", "psi", "u", "v", "r"}
            Of what.
        by : str
            By what.

        Raises
        ------
        InputError
            Where it was not asked for.
        """
        if state not in STATES or by not in self.by:
            raise InputError(f"there is no derivative of {state} by {by}; by: {', '.join(self.by)}")
        slope: np.ndarray = self.slopes[:, tuple(STATES).index(state), self.by.index(by)]
        return slope

    def standard_deviations(self) -> "xarray.Dataset":
        """Return how uncertain the state is for what is uncertain of the coefficients in ``by``, to first order.

        Raises
        ------
        InputError
            Where the model has no covariance.
        """
        import xarray

        if self.model.covariance is None:
            raise InputError("no covariance of the coefficients is known; fit the model, or load one that was fitted")
        names = self.model.terms.names
        places = [(names.index(name), column) for column, name in enumerate(self.by) if name in names]
        rows, columns = (list(part) for part in zip(*places, strict=True)) if places else ([], [])
        covariance, slopes = self.model.covariance[np.ix_(rows, rows)], self.slopes[:, :, columns]
        variance = np.einsum("tsi,ij,tsj->ts", slopes, covariance, slopes)
        spread = np.sqrt(np.maximum(variance, 0.0)).T
        data = {name: ("t", column, {"units": STATES[name]}) for name, column in zip(STATES, spread, strict=True)}
        return xarray.Dataset(data, coords={"t": ("t", self.voyage.t, {"units": "s"})})

    def for_one_percent(self) -> dict[str, float]:
        """Return how far each number, one percent larger, moves y at the end [m], the farthest first."""
        moved = {name: 0.01 * self.values[name] * float(self.of("y", name)[-1]) for name in self.by}
        return dict(sorted(moved.items(), key=lambda item: -abs(item[1])))

    def summary(self) -> str:
        """Say how it ended, and what moved it most."""
        most = [f"{name} {moved:+.3g} m" for name, moved in self.for_one_percent().items() if moved][:3]
        told = f"One percent more of each moves it by then to starboard by: {', '.join(most)}." if most else ""
        return "\n".join(filter(None, (self.voyage.summary(), told)))

    def to_dict(self) -> dict[str, Any]:
        """Give the derivatives at the end by name, with how the voyage ended."""
        end = dict(zip(STATES, self.slopes[-1], strict=True))
        slopes = {name: dict(zip(self.by, row.tolist(), strict=True)) for name, row in end.items()}
        return {"voyage": self.voyage.to_dict(), "at_end": slopes, "summary": self.summary(), "notes": list(self.notes)}

    def dataset(self) -> "xarray.Dataset":
        """Return the derivatives as an xarray Dataset: d of each state over the times and ``by``."""
        import xarray

        data = {
            f"d{name}": (("t", "by"), self.slopes[:, i], {"units": f"{unit} over the SI unit of by"})
            for i, (name, unit) in enumerate(STATES.items())
        }
        coordinates = {"t": ("t", self.voyage.t, {"units": "s"}), "by": list(self.by)}
        return xarray.Dataset(data, coords=coordinates, attrs={"summary": self.summary()})


def sensitivities(
    model: Model, by: Sequence[str] = (), y: float = 0.0, u: float = 1.0, duration: float | None = None,
    dt: float = 0.02, **voyage: Any,
) -> Sensitivities:  # fmt: skip
    """Differentiate a voyage by its start, coefficients, particulars and inputs, exactly.

    Every line of every step is differentiated along with it, so that the slopes are those of the computed voyage, to
    rounding. A control law in arithmetic is differentiated with the ship. Where a line has a kink, as ``abs(v)`` at
    0, its slope is the mean of both sides.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    by : sequence of str, optional
        Names: x, y, psi, u, v, r at the start; rudder and other actuators there; X, Y, N from elsewhere; current, in a
        waterway; coefficients; particulars; numbers of a control law. All the coefficients unless given.
    y : float [m]
        Start to starboard of the centreline.
    u : float [m/s]
        Surge velocity at the start.
    duration : float [s], optional
        Longest time, 60 s unless given.
    dt : float [s]
        Step.
    **voyage : Any
        As for ``simulate``.

    Returns
    -------
    Sensitivities
        With the voyage, and ``slopes`` at each of its times.

    Raises
    ------
    InputError
        Where the voyage cannot be, a name is unknown, or the controller is an object of Python.
    """
    if "at" in voyage:
        raise InputError("sensitivities come at the steps of the voyage; leave `at` out, and interpolate")
    names = tuple(by) or model.terms.names
    sailed = simulate(model, y, u, duration, dt, **voyage)
    march = TangentMarch.of(model, names, {"y": y, "u": u, **voyage})
    return Sensitivities(sailed, names, march.slopes(sailed.t), march.values, model)
