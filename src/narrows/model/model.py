"""A model: a ship in a canal, a table of terms, their coefficients, and their uncertainty."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial, reduce
from operator import add
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows
from narrows.base.aliases import CANAL, accept_aliases
from narrows.base.errors import InputError, check_choice, check_count, did_you_mean, shown
from narrows.base.named_values import Coefficients, Forces
from narrows.base.results import BaseResult
from narrows.model.data_range import DataRange, unknown_note
from narrows.model.sections import Source, fields_of, sections_of
from narrows.model.tables import without_bank
from narrows.model.term import Term, TermTable
from narrows.quantities.names import ACCELERATIONS, MOTION, Number
from narrows.ship.checks import check_ahead, check_angles, is_finite
from narrows.ship.motion import Motion
from narrows.ship.particulars import Configuration, Configured

if TYPE_CHECKING:
    import pandas as pd

# The verdict that needs no note, and the start of a verdict that is a verb phrase: "rests on ...".
SETTLED, VERB = "identified", "rests"
NO_SUCTION = "The model's bank coefficients are 0: the banks of a canal end a voyage without any force before."


# Functions of higher packages as methods of a model, through the public module, which loads them on demand.
class Operations(BaseResult):
    """Simulation, derivatives and equations of a model, as methods."""

    def derivative(self: Any, *at: Any, **given: Any) -> np.ndarray:
        """Return the rates of x, y, psi, u, v, r of the free ship at a state, (6,...), from the engine, in SI.

        A time may stand before the state, as integrators of SciPy give it.
        """
        return narrows.derivative(self, *at[len(at) == 2 and np.ndim(at[0]) == 0 :], **given)

    def linearize(self: Any, *at: float, **options: Any) -> "narrows.control.LinearSystem":
        """Linearise the motion about a steady course at y [m] and u [m/s], to a ``LinearSystem``."""
        return narrows.control.linearize(self, *at, **options)

    def simulate(self: Any, *start: float, **given: Any) -> "narrows.Voyage":
        """Simulate one voyage, from y [m] at u [m/s], to a ``Voyage``."""
        return narrows.simulate(self, *start, **given)

    def scale(self: Any, length: float, **given: Any) -> "narrows.Scaled":
        """Scale the model to a length [m] by Froude's law: a ``Scaled``, with the effects that do not scale."""
        return narrows.scale_model(self, length, **given)

    @accept_aliases
    def export(self: Any, path: str | Path, **options: Any) -> Any:
        """Write the model in another language, chosen by the file's suffix, as ``nw.export.write``."""
        return narrows.export.write(self, path, **options)

    def with_canal(self: Any, **changes: float) -> Any:
        """Return the model in another canal [m] with its coefficients; ``nw.at_depth`` corrects them for depth."""
        canal = self.configuration.canal
        for name in changes:
            check_choice("canal", name, tuple(vars(canal)))
        return replace(self, configuration=replace(self.configuration, canal=replace(canal, **changes)))

    def latex(self: Any, numbers: bool = False, forces: Sequence[str] = ("X", "Y", "N")) -> str:
        """Write the equations of the forces in LaTeX, one line per force."""
        return narrows.latex(self.terms, self.coefficients if numbers else None, forces)

    to_latex = latex

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Methods ``to_c``, ``to_fmu`` ..."""
            if name.startswith("to_") and name[3:] in narrows.export.LANGUAGES:
                return partial(narrows.export.to_language, self, name[3:])
            return super().__getattr__(name)


@dataclass(frozen=True, repr=False, eq=False)
class Model(Configured, Operations):
    """A bank-effect model: the result of a fit and the input of simulation.

    Raises an InputError if a coefficient is missing, unknown or not finite, or a verdict is unknown.

    >>> model = nw.published("mikkelsen2025_dtc")
    >>> round(float(model.forces(y=0.5, u=1.0)["Y"]), 2)
    14.22
    """

    configuration: Configuration  #: Ship, canal and water
    terms: TermTable  #: The terms
    coefficients: Mapping[str, float]  #: One value for each term, in the term's own SI unit
    covariance: np.ndarray | None = None  #: Covariance of the coefficients, in the order of ``terms.names``
    data_range: DataRange = field(default_factory=DataRange)  #: Tested range of the data
    source: Source = field(default_factory=Source)  #: Origin of the numbers
    #: Verdict on each coefficient, in a word or two; empty without a fit
    verdicts: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        names = self.terms.names
        for name, value in self.coefficients.items():
            if name not in names:
                hint = did_you_mean(name, names)
                raise InputError(f"unknown coefficient {name!r}{hint}")
            if not is_finite(value):
                raise InputError(f"coefficient {name} = {shown(value)} is not a finite number; give its value")
        for name in names:
            if name not in self.coefficients:
                raise InputError(f"coefficient {name} is missing; add it, or choose a table without its term")
        for name, verdict in self.verdicts.items():
            if name not in names or not isinstance(verdict, str) or not verdict.isprintable():
                raise InputError(f"the verdict {shown(verdict)} on {name!r} is no words on a coefficient; leave it out")

    def __repr__(self) -> str:
        return f"<Model of {self.ship.name}: {len(self.coefficients)} coefficients of the terms {self.terms.name}>"

    def __eq__(self, other: object) -> bool:
        same = (np.array_equal(getattr(self, own.name), getattr(other, own.name)) for own in fields(self))
        return isinstance(other, Model) and all(same)

    def __getitem__(self, name: str) -> float:
        """The value of a coefficient [SI]."""
        if name not in self.coefficients:
            raise InputError(f"unknown coefficient {name!r}{did_you_mean(name, self.terms.names)}")
        return self.coefficients[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.terms.names)

    @property
    def notes(self) -> tuple[str, ...]:
        """Main notes: the data of an estimate, and uncertain bank coefficients."""
        return tuple(filter(None, (self.source.estimate, *self.bank_notes)))

    def summary(self) -> str:
        table = f"{len(self.terms)} coefficients of the terms {self.terms.name}"
        return f"{self.configuration.summary()}.\n{table}{self.source.text and f'; {self.source.text}'}."

    def __str__(self) -> str:
        return f"{self.summary()}\n\n{self.to_dataframe().dropna(axis=1, how='all')}"

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the coefficients as a table: one row each, with value, std, unit and verdict."""
        import pandas as pd

        names = list(self.terms.names)
        std = np.full(len(names), np.nan) if self.covariance is None else np.sqrt(np.diag(self.covariance))
        columns = {
            "value": [self.coefficients[name] for name in names],
            "std": std,
            "unit": [self.terms[name].dimension.unit for name in names],
            "verdict": [self.verdicts.get(name, "") for name in names],
        }
        return pd.DataFrame(columns, index=pd.Index(names, name="coefficient"))

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any], terms: TermTable | None = None) -> "Model":
        """Return the model from the ``tables`` of ``to_dict``, and the user's own ``terms`` if it has such."""
        return cls(**fields_of(tables, terms))

    def to_dict(self) -> dict[str, Any]:
        return sections_of(self)

    def save(self, path: str | Path) -> None:
        """Write it to a ``path`` as a model file, which ``load_model`` restores to the last bit.

        Raises an InputError if the file cannot be written.
        """
        narrows.save_model(self, path)

    def with_coefficients(self, changes: Mapping[str, float] = MappingProxyType({}), /, **values: float) -> "Model":
        """Return the model with some coefficients changed, given by name as a mapping ``changes`` or as ``values``.

        A ``width`` or ``depth`` is that of another canal, as of ``with_canal``. Raises an InputError for another name.
        """
        values = {**changes, **values}
        if sizes := {name: values.pop(name) for name in CANAL & values.keys()}:
            model: Model = self.with_canal(**sizes)
            return model.with_coefficients(values)
        verdicts = {name: verdict for name, verdict in self.verdicts.items() if name not in values}
        return replace(self, coefficients=Coefficients({**self.coefficients, **values}), verdicts=verdicts)

    def sample(self, n: int = 100, seed: int = 0) -> "pd.DataFrame":
        """Return ``n`` rows of coefficients, drawn from their covariance as ensembles draw them from a ``seed``.

        ``model.with_coefficients(table.loc[0])`` is the model of a row. Raises an InputError if there is no covariance,
        or ``n`` or the seed is no whole number from 0.
        """
        import pandas as pd

        for name, value in {"n": n, "seed": seed}.items():
            check_count(name, value)
        drawn = narrows.simulation.grid.sampled(self, n, seed)
        return pd.DataFrame({name: column.to_numpy() for name, column in drawn.items()})

    def predict(self, tests: Any = None, **quantities: Number) -> Any:
        """Return the forces on the rows of ``tests`` as a table, or those of ``forces`` at ``quantities`` by name."""
        if tests is None or isinstance(tests, Motion):
            return self.forces(tests, **quantities)
        read = tests if hasattr(tests, "blocks") else narrows.read_captive(tests, self.configuration)
        return read.force_rows(self.terms, self.coefficients)

    @accept_aliases
    def forces(
        self, motion: Motion | None = None, rudder: Number | None = None, revolutions: Number | None = None,
        **others: Number,
    ) -> dict[str, Number]:  # fmt: skip
        """Evaluate surge force [N], sway force [N] and yaw moment [N m] on the towing rig, for floats or columns.

        The ``motion`` may be given by its quantities instead, y, psi, u, v, r, udot ...; these and further actuators of
        the terms are ``others``, by name and at rest unless given. The ``rudder`` [rad] is positive if it turns the bow
        to starboard, and amidships unless given; ``revolutions`` [1/s] are those of the configuration unless given.

        Raises an InputError if a term needs a particular that the configuration lacks, or divides by a speed of 0, or
        there is no such actuator.
        """
        if motion is None:
            given = {name: others.pop(name) for name in ("psi", *MOTION) if name in others}
            given = {name: np.array(q) if isinstance(q, list | tuple) else q for name, q in given.items()}
            check_angles(given if rudder is None else {**given, "rudder": rudder})
            motion = Motion.at(**given) if "psi" in given else Motion(**given)
        if not isinstance(motion, Motion):
            raise InputError(f"motion = {shown(motion)} is no nw.Motion; give quantities by name, as u=1.0, y=0.5")
        check_ahead(revolutions, self.configuration.propeller)
        positions = {"rudder": rudder, "revolutions": revolutions, **others}
        values = self._values(motion, {name: value for name, value in positions.items() if value is not None})
        try:
            return Forces({force: self._sum(terms, values) for force, terms in self.terms.forces.items()})
        except ZeroDivisionError:
            raise InputError("terms of this model divide by the speed; give u over 0") from None

    def resistance(self, u: float, **positions: Number) -> float:
        """Return the resistance of water and actuators straight ahead on the centreline at ``u`` [m/s], in newtons.

        ``positions`` are those of actuators. Raises an InputError as ``forces`` does.
        """
        return -float(self.forces(Motion.at(u=u), **positions)["X"])

    def bank_forces(self, motion: Motion) -> dict[str, Number]:
        """Evaluate the bank's part of each force [N, N, N m] in a ``motion`` of floats or columns."""
        values = self._values(motion)
        return {
            force: self._sum([term for term in terms if term.from_bank], values)
            for force, terms in self.terms.forces.items()
        }

    @property
    def _bank_names(self) -> list[str]:
        return [term.name for term in self.terms.terms if term.from_bank and self.coefficients[term.name]]

    @property
    def has_bank(self) -> bool:
        """Return whether it has a bank force: terms of the bank, not all zero."""
        return bool(self._bank_names)

    @property
    def bank_note(self) -> str:
        """Note that the model has no bank force; empty if it has one."""
        return "" if self.has_bank else self.terms.bank_note or NO_SUCTION

    @property
    def trust_note(self) -> str:
        """Note on bank coefficients that the tests do not determine; empty if there are none."""
        doubted = [
            f"{name} {'' if verdict.startswith(VERB) else 'is '}{verdict}"
            for name in self._bank_names
            if (verdict := self.verdicts.get(name, SETTLED)) != SETTLED
        ]
        without = "No tests of this ship" if self.source.estimate else "The tests do not"
        return f"{without} determine the bank force: {', '.join(doubted)}." if doubted else ""

    @property
    def bank_notes(self) -> tuple[str, ...]:
        """Notes on the banks: no force, uncertain or unknown coefficients, unknown ranges, assumed values."""
        trust = self.bank_note, self.trust_note, self.unknown_note, unknown_note(self.data_range, self.has_bank)
        return tuple(filter(None, (*trust, *self.configuration.notes)))

    @property
    def unknown_note(self) -> str:
        """Note on bank coefficients without a verdict or a covariance; empty if there are none."""
        banks = self._bank_names
        unjudged = [name for name in banks if name not in self.verdicts]
        missing = ["verdict"] * bool(unjudged) + ["covariance"] * (self.covariance is None)
        if not (banks and missing):
            return ""
        names = ", ".join(unjudged or banks)
        return f"How well tests determine {names} is not known: the model has no {' and no '.join(missing)}."

    def in_open_water(self) -> "Model":
        """Return the model without the terms of the banks; itself if it has none."""
        if not self.terms.has_bank:
            return self
        terms = without_bank(self.terms)
        indices = [self.terms.names.index(name) for name in terms.names]
        return replace(
            self, terms=terms, coefficients=Coefficients({name: self.coefficients[name] for name in terms.names}),
            covariance=None if self.covariance is None else self.covariance[np.ix_(indices, indices)],
            verdicts={name: verdict for name, verdict in self.verdicts.items() if name in terms.names},
        )  # fmt: skip

    def _values(self, motion: Motion, positions: Mapping[str, Number] = MappingProxyType({})) -> dict[str, Number]:
        values = {**self.configuration.values(), **motion.values()}
        actuators = {actuator.name: actuator for actuator in self.terms.actuators}
        for name in positions:
            if name not in actuators:
                hint = did_you_mean(name, actuators) if actuators else "; leave it out"
                raise InputError(f"the terms of this model have no actuator {name!r}{hint}")
        for name, actuator in actuators.items():
            position = positions.get(name, values.get(name, actuator.rest))
            if position is not None:
                values |= actuator.placed(position)
        for name in self.terms.inputs:
            if name not in values:
                raise InputError(f"the terms of this model need {name}; give it in the ship file")
        return values

    @property
    def mass_matrix(self) -> np.ndarray:
        """Mass and added mass of the terms against accelerations of u, v and r: (3, 3) [kg, kg m, kg m2]."""
        still, rates = self._steady_values, ACCELERATIONS.values()
        return np.array([[self._resisted(still, force, rate) for rate in rates] for force in self.terms.forces])

    @property
    def surge_inertia(self) -> float:
        """Inertia of the terms against a surge acceleration [kg]."""
        return self._resisted(self._steady_values, "X", "udot")

    @property
    def _steady_values(self) -> dict[str, Number]:
        return self._values(Motion.at(u=1.0), {actuator.name: 0.0 for actuator in self.terms.actuators})

    def _resisted(self, still: dict[str, Number], force: str, rate: str) -> float:
        """Return the part of a force that resists a unit of an acceleration."""
        pushed, terms = {**still, rate: 1.0}, self.terms.forces[force]
        return float(sum(self.coefficients[one.name] * (one.column(still) - one.column(pushed)) for one in terms))

    def _sum(self, terms: tuple[Term, ...] | list[Term], values: Mapping[str, Number]) -> Number:
        # Not by sum(): from Python 3.12 it compensates floats but not columns, so that they would differ by a rounding.
        return reduce(add, (self.coefficients[term.name] * term.column(values) for term in terms), 0.0)
