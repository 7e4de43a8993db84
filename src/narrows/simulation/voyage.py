"""One voyage: its track, and where, when and on which side the ship grounds."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows
from narrows.base.aliases import accept_aliases, name_here
from narrows.base.errors import InputError, check_choice
from narrows.base.results import Tabulated, same_content
from narrows.codegen.free_motion import COUNTED, INPUTS, MIDSHIP, OPEN, Surge
from narrows.codegen.kernels import event
from narrows.model.data_range import Measure
from narrows.model.model import Model
from narrows.model.water import is_full
from narrows.quantities.names import MOTION
from narrows.ship.actuators import PROPELLER, Actuator
from narrows.ship.checks import check_ahead, check_angles
from narrows.ship.particulars import Configuration
from narrows.simulation import initial_state as steps
from narrows.simulation import inputs
from narrows.simulation import outcome as end
from narrows.simulation.outcome import Code, Outcome, froude_notes, measured, outside_notes, water_notes
from narrows.simulation.settings import MOST_ROWS, STEP_ERROR_LIMIT
from narrows.simulation.ship import Points, SimulatedShip, points_of, steering_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.animation import FuncAnimation

    from narrows.waterway.waterway import Waterway

COLUMNS = ("t", "x", "y", "psi", "u", "v", "r", "rudder")
ON_EARTH = {
    "longitude": ("degrees_east", "longitude, WGS84"), "latitude": ("degrees_north", "latitude, WGS84"),
    "heading_deg": ("deg", "heading, clockwise from north"),
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class Voyage(Tabulated):
    """A voyage, row by row, and its outcome.

    >>> voyage = nw.simulate(model, y=0.5, u=1.0)
    >>> round(float(voyage.final.t), 2)
    11.79
    """

    t: np.ndarray  #: Time, (times,) [s]
    x: np.ndarray  #: Position of midship along the canal [m]
    y: np.ndarray  #: Position of midship to starboard of the centreline [m]
    psi: np.ndarray  #: Heading [rad]
    u: np.ndarray  #: Surge velocity through the water [m/s]
    v: np.ndarray  #: Sway velocity through the water [m/s]
    r: np.ndarray  #: Yaw rate [rad/s]
    rudder: np.ndarray  #: Angle of the rudder [rad]
    outcome: Outcome  #: Outcome of the voyage
    configuration: Configuration  #: Ship and canal
    waterway: "Waterway | None" = None  #: Waterway instead of that canal
    #: Points of the hull that meet a bank, forward and to starboard of midship [m]
    outline: tuple[tuple[float, float], ...] = ()
    #: Positions of other actuators with orders: revolutions [1/s]
    moved: Mapping[Actuator, np.ndarray] = field(default_factory=dict)
    __eq__ = same_content

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: Any) -> Any:
        """Return a column: t, x, y, psi, u, v, r, rudder, or another actuator's; rows or several as a table."""
        if not isinstance(name, str):
            rows = self.to_dataframe()
            return rows.iloc[name] if isinstance(name, int | np.integer) else rows[name]
        moved = {actuator.name: column for actuator, column in self.moved.items()}
        name = name_here(name, "attributes", {*COLUMNS, *moved}.__contains__) or name
        check_choice("column", name, (*COLUMNS, *moved))
        return moved[name] if name in moved else getattr(self, name)

    @property
    def grounded(self) -> bool:
        """True if it ended at a bank."""
        return self.outcome.kind == "grounded"

    @property
    def duration(self) -> float:
        """Its duration [s]."""
        return self.outcome.time

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of its outcome."""
        return self.outcome.notes

    def summary(self) -> str:
        return self.outcome.sentence

    def to_dict(self) -> dict[str, Any]:
        return self.outcome.to_dict()

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the voyage as a table: one row per time, with the columns t, x, y, psi, u, v, r and rudder."""
        frame: pd.DataFrame = self.dataset().to_dataframe().reset_index()
        return frame

    @property
    def clearance(self) -> np.ndarray:
        """Distance of the hull to the nearer bank of the local straight canal, (times,) [m]; negative beyond it."""
        canal, draft = self.configuration.canal, self.configuration.ship.draft
        width, middle = (canal.width, 0.0) if self.waterway is None else self.waterway.section(self.x, draft)[:2]
        forward, aside = np.transpose(self.outline or ((0.0, 0.0),))
        across = self.y + np.outer(forward, np.sin(self.psi)) + np.outer(aside, np.cos(self.psi))
        return np.asarray((width / 2 - np.abs(across - middle)).min(axis=0))

    @property
    def final(self) -> "pd.Series[float]":
        """The last row: t, x, y, psi, u, v, r and rudder at the end."""
        return self.to_dataframe().iloc[-1]

    def at(self, t: Any) -> "pd.Series[float] | pd.DataFrame":
        """Return the state at a time ``t`` [s] or several, interpolated linearly; an InputError if it is no number."""
        import pandas as pd

        from narrows.simulation.grid import labelled  # xarray loads slowly

        t, rows = labelled("t", t).to_numpy(), self.to_dataframe().set_index("t")
        frame = pd.DataFrame(
            {name: np.interp(t, rows.index, column, np.nan, np.nan) for name, column in rows.items()}, np.atleast_1d(t)
        )
        if "heading_deg" in frame:  # It jumps at north.
            turned = np.unwrap(rows["heading_deg"], period=360.0)
            frame["heading_deg"] = np.interp(t, rows.index, turned, np.nan, np.nan) % 360
        return frame.iloc[0] if np.ndim(t) == 0 else frame.rename_axis("t")

    def animate(self, path: str | Path | None = None, seconds: float = 8.0) -> "FuncAnimation":
        """Show an animation of the ship between its banks, which lasts ``seconds``.

        Write it to ``path``: a ``.gif``, or ``.html`` with buttons. In a notebook,
        ``HTML(voyage.animate().to_jshtml())`` shows it.

        Raises an InputError if the suffix is another, or the file cannot be written.
        """
        return narrows.report.animation_of(self, path, seconds)

    def dataset(self) -> "xarray.Dataset":
        """Return the voyage as an xarray Dataset with units."""
        import xarray

        meanings = {**MOTION, "psi": ("rad", "heading"), "rudder": ("rad", "rudder angle")}
        columns = {name: (getattr(self, name), *meanings[name]) for name in COLUMNS[1:]}
        columns |= {actuator.name: (column, actuator.unit, actuator.meaning) for actuator, column in self.moved.items()}
        if self.waterway is not None and self.waterway.origin is not None:
            columns |= {name: (column, *ON_EARTH[name]) for name, column in self._on_earth().items()}
        attributes = {"outcome": self.outcome.kind, "side": self.outcome.side or "", "summary": self.outcome.sentence}
        data = {name: ("t", column, {"units": u, "long_name": of}) for name, (column, u, of) in columns.items()}
        return xarray.Dataset(data, coords={"t": ("t", self.t, {"units": "s", "long_name": "time"})}, attrs=attributes)

    def _on_earth(self) -> dict[str, np.ndarray]:
        if self.waterway is None or self.waterway.origin is None:
            raise InputError("a track on a map needs a waterway with a position on earth (--waterway canal.geojson)")
        from narrows.waterway.map_lines import unprojected

        positions, heading = self.waterway.to_map(self.x, self.y, self.psi)
        longitude, latitude = unprojected(positions, np.array(self.waterway.origin)).T
        return {"longitude": longitude, "latitude": latitude, "heading_deg": np.degrees(heading) % 360}

    def geojson(self) -> str:
        """Return its track on earth: a LineString with times and headings, and a Point at its end.

        Raises an InputError if its waterway has no place on earth.
        """
        longitude, latitude, heading = self._on_earth().values()
        points = np.stack([longitude, latitude], axis=1).round(9).tolist()
        times = {"t": self.t.round(3).tolist(), "heading_deg": heading.round(3).tolist()}
        line, end = {"name": self.configuration.ship.name, **times}, {"name": "end"}
        features = [
            {
                "type": "Feature", "properties": {**more, "summary": self.outcome.sentence},
                "geometry": {"type": kind, "coordinates": places},
            }
            for more, kind, places in ((line, "LineString", points), (end, "Point", points[-1]))
        ]  # fmt: skip
        return json.dumps({"type": "FeatureCollection", "features": features}, indent=1)


@accept_aliases
def simulate(
    model: Model, y: float = 0.0, u: float | None = None, duration: float | None = None, dt: float | None = None, *,
    x: float = 0.0, psi: float = 0.0, v: float = 0.0, r: float = 0.0,
    X: inputs.Schedule = 0.0, Y: inputs.Schedule = 0.0, N: inputs.Schedule = 0.0, rudder: float = 0.0,
    surge: Surge = "held", surge_inertia: float | None = None, coriolis: bool = False,
    contact: inputs.Contact | Points = "corners", waterway: "Waterway | None" = None, controller: Any = None,
    hold: float | None = None, bottom: bool = True, **positions: float,
) -> Voyage:  # fmt: skip
    """Simulate one voyage until the ship grounds or the time is up.

    The method is the classical Runge-Kutta method of order 4 with step ``dt``; a contact is located within its step.

    Raises an InputError if an input is not finite, the hull starts in a bank, or an inertia or a rudder is missing.

    Parameters
    ----------
    model, y : Model, float [m]
        The ship in its canal, and its start to starboard of the centreline.
    u : float [m/s], optional
        Surge velocity at the start; the default suits the ship: within the tested range, and below choking.
    duration : float [s], optional
        Longest duration; default: the time of 15 ship lengths.
    dt : float [s], optional
        Step, and the spacing of the output; default: a 200th of the time of a ship length.
    x, psi, v, r : float [m, rad, m/s, rad/s]
        Place along the canal, heading, sway velocity and yaw rate at the start.
    X, Y, N : float or pairs [N, N, N m]
        External surge force, sway force, yaw moment: a constant, or (time, value) pairs, each valid until the next.
    rudder : float [rad]
        Angle at the start, for models with terms of the rudder; positive if it turns the bow to starboard. It is
        constant without a controller.
    surge, surge_inertia : str, float [kg], optional
        ``held``: constant speed; ``free``: it is integrated, with this mass and added mass if a_udot is unknown.
    coriolis : bool
        Add the rigid body's Coriolis force; damping fitted at one speed already contains it.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` (paper), an outline (forward, starboard); ``none``: open water.
    waterway : Waterway, optional
        Waterway instead of the model's own canal: x is along its line, y to starboard of it, psi relative to it, u and
        v through the water; the voyage ends at its end.
    controller : ControlLaw or Controller, optional
        Gives orders each step; the model's steering gear follows them.
    hold : float [m], optional
        Offset that the default helm, ``control.regulator``, holds.
    bottom : bool
        End the voyage if the ship touches the bottom by its squat, or chokes the section; ignored at unknown depth.
    **positions : float
        Starting positions of other actuators by name: revolutions [1/s], or one of the model's own.

    Examples
    --------
    >>> print(nw.simulate(model, y=0.5, u=1.0).outcome.ending)
    Grounded to port after 11.79 s and 11.16 m along the canal, at 1.01 m/s, heading -27.1 deg.
    """
    inputs.check_waterway(waterway)
    defaults = steps.voyage_defaults(model, None if u is None else [inputs.finite_numbers(u=u)["u"]])
    u = defaults.speed if u is None else u
    duration, dt = defaults.duration if duration is None else duration, defaults.dt if dt is None else dt
    duration, dt = inputs.check_steps(duration, dt, MOST_ROWS)
    ship = SimulatedShip(model, surge, surge_inertia, coriolis, contact, bottom)
    pushes = inputs.segments_of(X, Y, N, duration)
    steps.check_positions(positions, ship)
    numbers = inputs.finite_numbers(x=x, y=y, psi=psi, u=u, v=v, r=r, rudder=rudder, **positions)
    check_angles(numbers)
    steps.check_irrelevant(ship, {"rudder": rudder, "X": any(push.forces[0] for push in pushes)})
    if hold is not None:
        if controller is not None:
            raise InputError("hold is the line of the default helm; leave it or the controller out")
        controller = narrows.control.regulator(model, hold, u, waterway=waterway, at=x if waterway else 0.0)
    steering = steering_of(controller, ship.actuators)
    integrator, start = steps.initial_state(ship, steering, numbers, waterway, any(any(push.forces) for push in pushes))
    rows = [steps.Row(0.0, start)]
    clear = integrator.clearance(start)[0] > 0 or start[0] == integrator.channel.start
    ending = event.FINISHED if clear else event.CLOSED
    for push in pushes if ending == event.FINISHED else ():
        integrator.set(**dict(zip(INPUTS.values(), push.forces, strict=True)))
        ending = integrator.integrate(rows, push.stop, dt)
        if ending != event.FINISHED:
            break
    shown = [row for row in rows if row.whole]
    propeller = steps.propeller_notes(model, u, positions.get(PROPELLER.name), steering)
    log = _Log(ship, integrator, rows, ending, float(psi), float(rudder), propeller)
    outline = tuple(points_of(model.configuration.ship, ship.shape)) if ship.shape not in (MIDSHIP, OPEN) else ()
    return Voyage(
        **log.columns(shown), outcome=log.outcome(dt, waterway), configuration=model.configuration, waterway=waterway,
        outline=outline, moved=log.moved(shown),
    )  # fmt: skip


@dataclass(frozen=True)
class _Log:
    ship: SimulatedShip
    integrator: steps.VoyageIntegrator
    rows: list[steps.Row]
    ending: int
    psi: float
    rudder: float
    propeller: tuple[str, ...]  # Notes on its revolutions

    def kept(self, rows: list[steps.Row]) -> dict[str, np.ndarray]:
        return dict(zip(self.integrator.choices.kept, np.array([row.state for row in rows]).T, strict=True))

    def columns(self, rows: list[steps.Row]) -> dict[str, np.ndarray]:
        kept, track = self.kept(rows), ("x", "y", "u", "v", "r")
        psi = inputs.counted_heading(kept["cos_psi"], kept["sin_psi"], kept.get(COUNTED, self.psi))
        columns = {"psi": psi, "rudder": kept.get("rudder", np.full(len(rows), self.rudder))}
        return {"t": np.array([row.t for row in rows]), **{name: kept[name] for name in track}, **columns}

    def moved(self, rows: list[steps.Row]) -> dict[Actuator, np.ndarray]:
        kept, actuators = self.kept(rows), self.ship.model.terms.actuators
        moved = {one: kept[one.name] for one in actuators if one.name in kept and one.name != "rudder"}
        check_ahead(moved.get(PROPELLER), self.ship.model.configuration.propeller)
        return moved

    def outcome(self, dt: float, waterway: "Waterway | None") -> Outcome:
        columns, integrator, at_end = self.columns(self.rows), self.integrator, self.rows[-1].state
        model, is_open = self.ship.model, self.ship.shape == OPEN
        code = Code(integrator.channel.codes(integrator.cause(self.ending, at_end), at_end[0]).item())
        full, nearer = is_full(model.configuration.ship.block_coefficient), integrator.clearance(at_end)[1] > 0
        side = end.SIDES.get(code, {}).get(1 if (full if code == Code.TOUCHED else nearer) else -1)
        bank = model.configuration.notes if is_open else model.bank_notes
        water = () if is_open and waterway is None else water_notes(waterway, model.configuration.canal.depth)
        notes = (*bank, *water, *self.propeller, *self._beyond(columns), *self._coarse(dt))
        state = {name: float(columns[name][-1]) for name in ("x", "y", "psi", "u", "v", "r")}
        distance, passed = state["x"] - float(columns["x"][0]), code == Code.PASSED
        return Outcome(
            end.KINDS[code], self.rows[-1].t, distance, end.WAYS.get(code) or side, state, notes,
            abs(distance) / model.configuration.ship.length,
            integrator.least_clearance(self.rows) if passed else None,
            float(np.abs(columns["rudder"]).max()) if passed and "rudder" in integrator.choices.kept else None,
        )  # fmt: skip

    def _beyond(self, columns: dict[str, np.ndarray]) -> tuple[str, ...]:
        model, t = self.ship.model, columns["t"]

        def beyond(measure: Measure, covered: str, outside: Any, values: Any) -> str:
            first = int(np.argmax(np.broadcast_to(outside, t.shape)))
            there = measure.describe(*2 * (float(np.broadcast_to(values, t.shape)[first]),))
            return f"From {t[first]:.2f} s its {measure.words} of {there} is outside the data ({covered})."

        section = self.integrator.channel.section(columns["x"])
        seen = measured(columns, {**model.configuration.values(), **section}, self.ship.shape != OPEN)
        return (*froude_notes(columns["u"], model.ship.length), *outside_notes(model.data_range, [seen], beyond))

    def _coarse(self, dt: float) -> tuple[str, ...]:
        error = 0.0 if self.ending == event.LOST else steps.track_error(self.integrator, self.rows, dt)
        if not error > STEP_ERROR_LIMIT * self.ship.model.configuration.ship.beam:
            return ()
        return (f"A time step of {dt:g} s is too long: the track is off by some {error:.2g} m; shorten it.",)
