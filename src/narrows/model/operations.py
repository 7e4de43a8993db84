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
        """Return the rates of x, y, psi, u, v, r of the free ship, (6,...), as the engine has them."""
        # state [m]
        model: Any = self
        return narrows.derivative(model, state, **given)

    def step(self, state: Any, dt: float, **given: Any) -> np.ndarray:
        """Return x, y, psi, u, v, r one step of the engine later, (6,)."""
        # state [m]; dt [s]
        model: Any = self
        return narrows.step(model, state, dt, **given)

    def linearize(self, **at: Any) -> "narrows.Jacobian":
        """Return the exact derivatives of the motion about a state, a ``Jacobian``."""
        model: Any = self
        return narrows.jacobian(model, **at)

    def simulate(self, *start: float, **given: Any) -> "narrows.Voyage":
        """Simulate one voyage, to a ``Voyage``."""
        # *start [m]
        model: Any = self
        return narrows.simulate(model, *start, **given)

    def scale(self, length: float, **given: Any) -> "narrows.Scaled":
        """Scale the model by Froude's law: a ``Scaled``, with the new model and what does not scale."""
        # length [m]
        model: Any = self
        return narrows.scale_model(model, length, **given)

    def with_canal(self, **changes: float) -> Any:
        """Return the model in another canal, its coefficients as they are: ``nw.at_depth`` corrects those for depth."""
        # **changes [m]
        model: Any = self
        canal = model.configuration.canal
        for name in changes:
            check_choice("canal", name, tuple(vars(canal)))
        return replace(model, configuration=replace(model.configuration, canal=replace(canal, **changes)))

    def latex(self, numbers: bool = False, forces: Sequence[str] = ("X", "Y", "N")) -> str:
        """Write the equations of the forces in LaTeX, a line a force."""
        model: Any = self
        coefficients = model.coefficients if numbers else None
        return narrows.latex(model.terms, coefficients, forces)
