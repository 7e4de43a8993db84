"""Many voyages at once (grids and Monte Carlo samples), on all cores, and measures of their results."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

import narrows
from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_choice
from narrows.base.progress import bar
from narrows.codegen.free_motion import OPEN, Surge
from narrows.model.data_range import Measure
from narrows.model.model import Model
from narrows.model.term import TermKind
from narrows.ship.actuators import PROPELLER
from narrows.simulation import settings
from narrows.simulation.grid import NOT_RUN, AliasedDataset, Grid, attributes_of, grid_of, labelled, sizes_of
from narrows.simulation.initial_state import check_irrelevant, propeller_notes, voyage_defaults
from narrows.simulation.inputs import Contact, check_steps, check_waterway, check_workers
from narrows.simulation.kernel_run import OUTPUTS, KernelRun, Result
from narrows.simulation.outcome import Code, measured, outside_notes, water_notes
from narrows.simulation.ship import Points, SimulatedShip, steering_of
from narrows.waterway.waterway import Waterway

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@accept_aliases
def ensemble(
    model: Model, *, duration: float | None = None, dt: float | None = None, samples: int = 0, seed: int = 0,
    surge: Surge = "held", surge_inertia: float | None = None, coriolis: bool = False,
    contact: Contact | Points = "corners", waterway: Waterway | None = None,
    controller: Any = None, hold: float | None = None, workers: int | None = None, progress: bool = False,
    bottom: bool = True, **vary: Any,
) -> "Fleet":  # fmt: skip
    """Simulate a voyage for every combination of the varied quantities.

    The ``Fleet`` has outcome, grounded, side, time [s], distance [m] and the state at the end, over the varied
    dimensions. After an interruption it holds the finished voyages, and ``complete`` is 0.

    Raises an InputError if a name is unknown or a value does not fit.

    Parameters
    ----------
    model, duration, dt : Model, float [s], float [s], optional
        As for ``simulate``; the defaults are those of the lowest and of the highest speed.
    samples, seed : int
        Number of coefficient samples from the fit's covariance, a dimension ``sample``, and their seed.
    surge, surge_inertia, coriolis, contact, waterway
        As for ``simulate`` [kg, m].
    controller : ControlLaw, optional
        A law in arithmetic that gives orders each step; its numbers may be DataArrays.
    hold : float [m], optional
        As for ``simulate``: the default helm of each speed.
    workers, progress : int, bool
        Threads, all cores unless given, which do not change the result; show a bar on stderr.
    bottom
        As for ``simulate``.
    **vary : number, sequence or DataArray
        Start (x, y [m], psi [rad], u, v [m/s], r [rad/s]), inputs (X, Y [N], N [N m]), heave [m], rudder [rad],
        particulars (width, depth, length, beam, draft [m], block_coefficient [1], density [kg/m3]) and coefficients
        by name. A sequence is a dimension of that name; DataArrays that share a dimension vary together.

    Examples
    --------
    >>> fleet = nw.ensemble(model, y=[0.2, 0.5], u=1.0)
    >>> fleet.distance.values.round(1).tolist()
    [20.2, 11.2]
    """
    check_workers(workers)
    check_waterway(waterway)
    ship = SimulatedShip(model, surge, surge_inertia, coriolis, contact, bottom)
    defaults = voyage_defaults(model)
    if hold is not None:
        controller = _helm(model, hold, controller, vary.get("u", defaults.speed), waterway)
    steering = steering_of(controller, ship.actuators, single=False)
    plain = grid_of(model, {"u": defaults.speed, **vary}, samples, seed)
    defaults = voyage_defaults(model, plain.values["u"])
    duration, dt = defaults.duration if duration is None else duration, defaults.dt if dt is None else dt
    duration, dt = check_steps(duration, dt, settings.MOST_STEPS)
    check_irrelevant(ship, vary)
    law = {name: labelled(name, value) for name, value in steering.parameters.items()} if steering else {}
    grid = Grid({**plain.values, **law}, sizes_of({**plain.values, **law}) or plain.sizes)
    if grid.vessels > settings.MOST_VOYAGES:
        raise InputError(f"{grid.vessels:.3g} voyages are too many for memory; vary less, or run parts of them")
    run = KernelRun(ship, duration, dt, steering, waterway)
    _check_waterway(run, grid, vary)
    kept, complete = _run_here(run, grid, workers, progress)
    data = {name: (list(grid.sizes), column, attributes_of(name)) for name, column in kept.items()}
    voyages = xr.Dataset(data, coords=grid.coordinates(), attrs={"complete": int(complete)})
    grounded = (voyages["outcome"] == Code.GROUNDED).assign_attrs(long_name="whether it grounded")
    voyages = voyages.assign(grounded=grounded).assign_attrs(notes="\n".join(notes_of(run, grid, voyages)))
    fleet = Fleet(voyages.data_vars, coords=voyages.coords, attrs=voyages.attrs)
    fleet._model, fleet._waterway = model, waterway
    return fleet


def _helm(model: Model, hold: float, controller: Any, u: Any, waterway: Waterway | None) -> Any:
    """Return the default helm for each speed ``u`` as one law, its numbers over the dimension of the speeds."""
    if controller is not None:
        raise InputError("hold is the line of the default helm; leave it or the controller out")
    speeds = labelled("u", u)
    laws = [narrows.control.regulator(model, hold, float(one), waterway=waterway) for one in speeds.values.flat]

    def over(own: list[Any]) -> Any:
        if isinstance(own[0], tuple):
            return tuple(over(list(numbers)) for numbers in zip(*own, strict=True))
        return speeds.copy(data=np.reshape(own, speeds.shape))

    lines = [law.lines[0] for law in laws]
    parts = {name: over([getattr(line, name) for line in lines]) for name in vars(lines[0]) if name != "start"}
    own = {name: over([getattr(law, name) for law in laws]) for name in ("u", "lead", "unwinding")}
    return replace(laws[0], lines=(replace(lines[0], **parts),), **own)


def _check_waterway(run: KernelRun, grid: Grid, vary: Mapping[str, Any]) -> None:
    if run.waterway is None:
        return
    for name in ("width", "depth", "length", "beam", "draft"):
        if name in vary:
            where = "comes from the waterway" if name in ("width", "depth") else "is built into the waterway's table"
            raise InputError(f"{name} {where}, so it cannot vary in one; leave it out")
    length, x = run.waterway.line.length, grid.values["x"]
    if not ((x >= 0) & (x < length)).all():
        raise InputError(f"x lies off {run.waterway.name}, 0 to {length:.0f} m, in some of these voyages; start on it")


def _run_here(run: KernelRun, grid: Grid, workers: int | None, progress: bool) -> tuple[Result, bool]:
    shape = tuple(grid.sizes.values())
    kept: Result = {
        name: np.full(shape, NOT_RUN if kind is np.int8 else np.nan, kind) for name, kind in OUTPUTS.items()
    }
    with bar(grid.vessels, progress) as advance:
        try:
            for block in grid.blocks(settings.BLOCK_VESSELS):
                values, part = grid.flat(block)
                for name, column in run.run(values, math.prod(part), workers).items():
                    kept[name][grid.region(block)] = column.reshape(part)
                advance(math.prod(part))
        except KeyboardInterrupt:
            return kept, False
    return kept, True


def notes_of(run: KernelRun, grid: Grid, voyages: xr.Dataset) -> tuple[str, ...]:
    model = run.ship.model
    varied = any(grid.values[term.name].dims for term in model.terms.terms if term.kind == TermKind.BANK)
    without = run.ship.shape == OPEN or (varied and not model.has_bank)
    bank = model.configuration.notes if without else model.bank_notes
    coarse = _coarse(run, grid, voyages) if voyages.attrs["complete"] else ()  # After an interruption simulate no more
    share = float((voyages["outcome"] == Code.DIVERGED).mean())
    lost = f"The motion diverged in {share:.1%} of these voyages: shorten the time step or look at the coefficients."
    known = run.waterway is None and (run.ship.shape == OPEN or "depth" in grid.values)
    water = () if known else water_notes(run.waterway, model.configuration.canal.depth)
    propeller = propeller_notes(model, grid.values["u"], grid.values.get(PROPELLER.name), run.steering)
    return (*bank, *water, *propeller, *coarse, *((lost,) if share else ()), *_beyond(run, grid, voyages))


def _coarse(run: KernelRun, grid: Grid, voyages: xr.Dataset) -> tuple[str, ...]:
    """Repeat a sample at half the step, and return the share that changed."""
    places = np.unique(np.linspace(0, grid.vessels - 1, settings.STEP_CHECK_VOYAGES).round().astype(int))
    numbers = np.unravel_index(places, tuple(grid.sizes.values()))
    index = {name: xr.DataArray(one, dims="vessel") for name, one in zip(grid.sizes, numbers, strict=True)}
    chosen = {name: value.isel(index, missing_dims="ignore") for name, value in grid.values.items()}
    values = {name: value.to_numpy() if value.dims else float(value) for name, value in chosen.items()}
    again = replace(run, dt=np.asarray(run.dt) / 2).run(values, len(places), 1)
    first = {name: voyages[name].isel(index).to_numpy() for name in ("outcome", "side", "distance", "y_end")}
    same_end = (again["outcome"] == first["outcome"]) & (again["side"] == first["side"])
    moved = np.hypot(again["distance"] - first["distance"], again["y_end"] - first["y_end"])
    changed = ~same_end | (moved > settings.STEP_ERROR_LIMIT * run.ship.model.configuration.ship.beam)
    if not changed.any():
        return ()
    return (
        f"A time step of {float(np.max(run.dt)):g} s is too long for {float(changed.mean()):.0%} of these voyages: at "
        f"half of it they end differently, or more than {settings.STEP_ERROR_LIMIT:.0%} of the beam off; shorten it.",
    )


def _beyond(run: KernelRun, grid: Grid, voyages: xr.Dataset) -> Iterator[str]:
    start, ship, every = grid.values, {**run.ship.values(), **grid.values}, xr.zeros_like(voyages["outcome"], bool)
    end = {"x": start["x"] + voyages["distance"], **{name: voyages[f"{name}_end"] for name in ("y", "psi", "u", "r")}}
    channel = None if run.waterway is None else run.channel({})
    moments = []
    for at in (start, end):
        section = channel.section(at["x"]) if channel else {}
        local = {name: at["x"].copy(data=column) for name, column in section.items()}
        moments.append(measured(at, {**ship, **local}, run.ship.shape != OPEN))

    def beyond(measure: Measure, covered: str, outside: Any, values: Any) -> str:
        share, article = float((every | outside).mean()), "an" if measure.words[0] in "aeiou" else "a"
        return f"{share:.1%} of these voyages begin or end with {article} {measure.words} outside the data ({covered})."

    return outside_notes(run.ship.model.data_range, moments, beyond)


def grounding_probability(voyages: xr.Dataset, distance: float, over: str = "sample") -> xr.DataArray:
    """Return the share of samples that ground within a distance [1].

    It is unknown (NaN) if a voyage ended before that distance in another way: its time ran out, it diverged, turned
    across the canal or left the waterway.

    Raises an InputError if the voyages have no such dimension.

    Parameters
    ----------
    voyages, distance, over : Fleet with samples, float [m], str
        Distance along the canal; the dimension of the samples.

    Examples
    --------
    >>> fleet = nw.ensemble(kcs, y=[0.0, 60.0], u=6.0, samples=4)
    >>> nw.grounding_probability(fleet, 1000.0).dims
    ('y',)
    """
    if over not in voyages.dims:
        raise InputError(f"these voyages have no dimension {over!r}; draw coefficients: ensemble(..., samples=200)")
    grounded, far = voyages["outcome"] == Code.GROUNDED, voyages["distance"] > distance
    within = (grounded & ~far).mean(over).where((grounded | far).all(over))
    return within.assign_attrs(units="1", long_name=f"probability of grounding within {distance:g} m")


def map_summary(voyages: xr.Dataset) -> dict[str, Any]:
    outcome, side = voyages["outcome"].to_numpy(), voyages["side"].to_numpy()
    distance = voyages["distance"].where(outcome == Code.GROUNDED).to_numpy()
    count = {code.name.lower(): int((outcome == code).sum()) for code in Code}
    sides = {"starboard": int((side > 0).sum()), "port": int((side < 0).sum())}
    near, left = (float(np.nanmin(distance)) if count["grounded"] else None), count["astern"] + count["passed"]
    parts = [
        f"{outcome.size} voyages: {count['grounded']} ground "
        f"({sides['starboard']} to starboard, {sides['port']} to port)",
        f", the nearest after {near:.2f} m" if near is not None else "",
        f"; {count['afloat']} are afloat at the end, {count['outside']} turn across the canal",
        f", {left} leave the waterway" * bool(left),
        f", {count['diverged']} diverge: shorten the time step or look at the coefficients" * bool(count["diverged"]),
    ]
    notes = str(voyages.attrs.get("notes", "")).splitlines()
    return {
        "voyages": int(outcome.size), "outcomes": count, "sides": sides, "nearest": near,
        "complete": bool(voyages.attrs["complete"]), "notes": notes,
        "summary": " ".join([f"{''.join(parts)}.", *notes]),
    }  # fmt: skip


class Fleet(AliasedDataset):
    """The result of ``ensemble``: an xarray Dataset whose ``plot()`` draws where the ships ground.

    A part of it (``isel``, ``where``) is a fleet without its model: its map
    has no title, and all of it is marked as untested.

    Examples
    --------
    >>> fleet = nw.ensemble(model, y=[0.2, 0.5])
    >>> fleet.grounded.values.tolist()
    [True, True]
    """

    __slots__ = ("_model", "_waterway")

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        return Flags(found) if key in ("outcome", "side") and found.dtype.kind == "i" else found

    def probability(self, kind: str = "grounded") -> xr.DataArray:
        """Return the share of samples that end in this ``kind``; of all voyages where none are drawn."""
        ends = (self.outcome == kind).drop_attrs().rename("probability")
        return ends.mean("sample" if "sample" in self.dims else None)

    def summary(self) -> str:
        """Return how many ground, on which side, and the nearest, in words."""
        return str(map_summary(self)["summary"])

    def to_xarray(self) -> xr.Dataset:
        """Return the data as a plain Dataset."""
        return xr.Dataset(self.data_vars, self.coords, self.attrs)

    def plot(self, within: float | None = None) -> "Figure":
        """Draw the map: ``plot()``, or ``plot(within=500.0)`` for the probability of grounding within 500 m."""
        model, waterway = (getattr(self, name, None) for name in ("_model", "_waterway"))
        return narrows.report.map_figure(self, model, within, waterway)


class Flags(xr.DataArray):  # type: ignore[misc]
    """Codes that are compared with the words of their ``flag_meanings`` too: ``fleet.outcome == "grounded"``."""

    __slots__ = ()

    def __eq__(self, other: Any) -> Any:
        if isinstance(other, str):
            words = [word.replace("_", " ") for word in self.attrs["flag_meanings"].split()]
            check_choice(str(self.name), other, words)
            other = self.attrs["flag_values"][words.index(other)]
        return super().__eq__(other)

    def __ne__(self, other: Any) -> Any:
        return ~(self == other)
