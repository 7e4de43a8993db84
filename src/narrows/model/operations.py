"""What the rooms above do with a model, as its methods: by the public face, which loads a room when it is asked for."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import narrows
from narrows.errors import check_choice
from narrows.results import Shown


class Operations(Shown):
    """Simulation, derivatives and equations of a model, by methods."""

    def derivative(self, state: Any, **given: Any) -> np.ndarray:
        """Return the rates of x, y, psi, u, v, r of the free ship, (6, ...), as the engine has them.

        Parameters
        ----------
        state : sequence of six numbers, or mapping of str to number
            x, y [m], psi [rad], u, v [m/s], r [rad/s]; floats or columns.
        **given : Any
            As for ``nw.derivative``: X, Y, N, rudder, revolutions, surge, surge_inertia, coriolis.
        """
        model: Any = self
        return narrows.derivative(model, state, **given)

    def step(self, state: Any, dt: float, **given: Any) -> np.ndarray:
        """Return x, y, psi, u, v, r one step of the engine later, (6,).

        Parameters
        ----------
        state : sequence of six numbers, or mapping of str to number
            x, y [m], psi [rad], u, v [m/s], r [rad/s].
        dt : float [s]
            Length of the step.
        **given : Any
            As for ``nw.derivative``.
        """
        model: Any = self
        return narrows.step(model, state, dt, **given)

    def linearize(self, **at: Any) -> "narrows.Jacobian":
        """Return the exact derivatives of the motion about a state, a ``Jacobian``.

        Parameters
        ----------
        **at : Any
            As for ``nw.jacobian``.
        """
        model: Any = self
        return narrows.jacobian(model, **at)

    def simulate(self, *start: float, **given: Any) -> "narrows.Voyage":
        """Simulate one voyage, to a ``Voyage``.

        Parameters
        ----------
        *start : float
            y [m], u [m/s], duration [s], dt [s], as for ``nw.simulate``.
        **given : Any
            As for ``nw.simulate``.
        """
        model: Any = self
        return narrows.simulate(model, *start, **given)

    def scale(self, length: float, **given: Any) -> "narrows.Scaled":
        """Scale the model by Froude's law: a ``Scaled``, with the new model and what does not scale.

        Parameters
        ----------
        length : float [m]
            Between perpendiculars, of the new ship.
        **given : Any
            As for ``nw.scale_model``.
        """
        model: Any = self
        return narrows.scale_model(model, length, **given)

    def with_canal(self, **changes: float) -> Any:
        """Return the model in another canal, its coefficients as they are: ``nw.at_depth`` corrects those for depth.

        Parameters
        ----------
        **changes : float [m]
            ``width``, ``depth``.

        Raises
        ------
        InputError
            Where a canal has no such key, or cannot be so.
        """
        model: Any = self
        canal = model.configuration.canal
        for name in changes:
            check_choice("canal", name, tuple(vars(canal)))
        return replace(model, configuration=replace(model.configuration, canal=replace(canal, **changes)))

    def latex(self, numbers: bool = False, forces: Sequence[str] = ("X", "Y", "N")) -> str:
        """Write the equations of the forces in LaTeX, a line a force.

        Parameters
        ----------
        numbers : bool
            With the values of the coefficients, to four digits, instead of their symbols.
        forces : sequence of str
            Which.

        Raises
        ------
        InputError
            Where there is no such force.
        """
        model: Any = self
        coefficients = model.coefficients if numbers else None
        return narrows.latex(model.terms, coefficients, forces)
