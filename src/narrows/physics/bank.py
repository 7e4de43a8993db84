"""The bank effect: suction to the near bank, and the cushion that turns the bow away from it.

Any parameter that says how much lower the pressure is on the side of the nearer bank makes a force and a moment by
one law; the parameters are in ``clearance``.
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from narrows.physics import clearance
from narrows.quantities.names import REGRESSOR_INPUTS, Number, described

SCALE = ("u", "heave", "length", "draft", "block_coefficient", "density")


@dataclass(frozen=True)
class Suction:
    """Sway force of the bank [N] per unit coefficient, 1/2 C_B rho L (T0 + z) u_w^2 times a pressure parameter.

    The paper leaves u_w open: here it is the surge velocity through the water.

    Parameters
    ----------
    parameter : callable
        A function of names of the vocabulary; what it asks for, the force asks for too.

    References
    ----------
    Mikkelsen et al. (2025), eq. (bank_sway_w_assum), for delta.
    """

    parameter: Callable[..., Number]
    kind: ClassVar[str] = "suction"
    what: ClassVar[str] = "Sway force of the bank [N]"

    def __post_init__(self) -> None:
        own = inspect.signature(self.parameter).parameters
        names = [name for name in REGRESSOR_INPUTS if name in own or name in SCALE]
        source = inspect.cleandoc(self.parameter.__doc__ or "").partition("Source:")[2].partition("\n\n")[0].strip()
        said = {
            "__signature__": inspect.Signature(
                [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in names]
            ),
            "__name__": f"{self.parameter.__name__}_{self.kind}",
            "__doc__": described(
                f"{self.what} per unit coefficient, by {self.parameter.__name__}.\n\nSource: {source}", names
            ),
        }
        for name, value in said.items():
            object.__setattr__(self, name, value)

    def __call__(self, *given: Number, **named: Number) -> Number:
        """Evaluate the force [N]; the arguments are those of the vocabulary, in its order."""
        return self._force(inspect.signature(self).bind(*given, **named).arguments)

    def _force(self, values: dict[str, Number]) -> Number:
        side = values["length"] * (values["draft"] + values["heave"])
        pressure = self.parameter(*[values[name] for name in inspect.signature(self.parameter).parameters])
        return 0.5 * values["block_coefficient"] * values["density"] * side * pressure * (values["u"] * values["u"])


@dataclass(frozen=True)
class Cushion(Suction):
    """Yaw moment of the bank [N m] per unit coefficient, -L times the sway force of the same parameter.

    The paper prints both signs; this one, of its regression matrix, turns the bow away from the bank.

    Parameters
    ----------
    parameter : callable
        A function of names of the vocabulary; what it asks for, the moment asks for too.

    References
    ----------
    Mikkelsen et al. (2025), Theta_N, for delta.
    """

    kind: ClassVar[str] = "cushion"
    what: ClassVar[str] = "Yaw moment of the bank [N m]"

    def _force(self, values: dict[str, Number]) -> Number:
        return -values["length"] * super()._force(values)


suction, cushion = Suction(clearance.delta), Cushion(clearance.delta)
