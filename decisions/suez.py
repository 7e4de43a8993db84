"""A large container ship in an idealised Suez section: what the models say at 8 to 14 knots, and how far they agree.

python decisions/suez.py [--write]

`make docs` draws its figure. The ship and the canal are those of the Ever Given's grounding of March 2021 as an
idealisation: 399.94 m long, h/T about 1.5, a canal 205 m wide and 24 m deep as a rectangle. No model of it exists:
the published model of the DTC and the KCS as measured are brought to its length.
"""

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from pages import markdown, publish

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.physics.squat_and_depth import depth_froude
from narrows.quantities.names import KNOT
from narrows.safety.headline import crossing
from narrows.safety.pilots import PILOTS
from narrows.safety.settings import SURE_SHARE

LENGTH, WIDTH, DEPTH, DENSITY = 399.94, 205.0, 24.0, 1025.0
SHIP = nw.Ship(LENGTH, 58.8, 15.85, 0.661, name="a ship of that size")
"""Beam and draft as reported; the block coefficient is the DTC's."""
SPEEDS = (8.0, 13.5, 14.0)
OFFSETS = (10.0, 20.0)
START, LONGEST, STEP = 2.0, 3600.0, 0.25
SAMPLES = 500
TRIED = 2000
HELD_AT = (0.0, 10.0, 20.0)
WHO = {"human": "human helmsman", "regulator": "one regulator"}
CLEARANCES = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"


INTERVALS = {"as identified": 1.0, "half as wide": 0.5}
"""Of the coefficients: standard deviations over those of the tests."""


def published() -> nw.Model:
    """The DTC, whose tests say nothing of a depth."""
    return nw.scale_model(nw.published("mikkelsen2025_dtc"), LENGTH, DENSITY, WIDTH, DEPTH).model


def measured() -> dict[str, nw.Model]:
    """The KCS by condition, each in water as deep for its draft as in its tests."""
    table, ship = measured_files("kcs")
    fits = nw.identify_conditions(nw.read_captive(table, ship, TURNED), terms=nw.STEERED)
    return {label: nw.scale_model(fit.model, LENGTH, DENSITY, width=WIDTH).model for label, fit in fits.items()}


def water() -> str:
    """What hydrodynamics of the canal says, whatever the bank's coefficients are."""
    configuration = nw.Configuration(SHIP, nw.Canal(WIDTH, DEPTH), nw.Water(DENSITY))
    choke, rows = nw.choke_speed(configuration), []
    for knots in SPEEDS:
        speed = knots * KNOT
        sinkage = max(nw.squat(configuration, speed, gives).sinkage for gives in ("midship", "bow", "largest"))
        shares = f"{depth_froude(speed, DEPTH):.2f}", f"{100 * speed / choke:.0f} %"
        rows.append((f"{knots:g}", *shares, f"{sinkage:.2f}", f"{DEPTH - SHIP.draft - sinkage:.2f}"))
    header = ("knots", "depth Froude number", "of choking", "largest sinkage [m]", "under the keel [m]")
    return f"The canal chokes at {choke / KNOT:.1f} knots.\n\n{markdown(header, rows)}"


def adrift(models: dict[str, nw.Model]) -> str:
    """From 2 m off the middle, the rudder amidships: how long it sails [s], and how far [ship lengths]."""
    rows, speeds = [], (SPEEDS[0], SPEEDS[-1])
    for name, model in models.items():
        ends = [nw.simulate(model, y=START, u=knots * KNOT, duration=LONGEST, dt=STEP).outcome for knots in speeds]
        rows.append((name, *(ended(end.kind, end.time, end.distance / LENGTH) for end in ends)))
    return markdown(("aground after", *(f"at {knots:g} knots" for knots in speeds)), rows)


def ended(kind: str, time: float, lengths: float) -> str:
    """How a voyage ends: the time and the distance of a grounding."""
    return f"{time:.0f} s, {lengths:.1f} lengths" if kind == "grounded" else kind


def steered(models: dict[str, nw.Model]) -> str:
    """The rudder that holds it, by offset: median of the samples, and where 90 % of them are."""
    rows = []
    for name, model in models.items():
        samples = {} if model.covariance is None else {"samples": SAMPLES}
        limit, cells = model.configuration.gear.limit_deg, []
        for offset in OFFSETS:
            angle = np.degrees(np.atleast_1d(nw.steady_course(model, y=offset, u=10 * KNOT, **samples)["rudder"]))
            low, middle, high = np.quantile(
                np.where(np.isnan(angle), np.inf, angle), (0.05, 0.5, 0.95), method="higher"
            )
            known = f" ({said(low, limit)} to {said(high, limit)})" if samples else ""
            cells.append(f"{said(middle, limit)}{known}")
        rows.append((name, *cells))
    return markdown(("rudder and 90 % interval [deg]", *(f"at {offset:g} m" for offset in OFFSETS)), rows)


def held(model: nw.Model, intervals: tuple[str, ...]) -> str:
    """Shares that pilots hold at 10 knots, with the intervals of the tests and with half of them."""
    rows = []
    for words in intervals:
        narrower = replace(model, covariance=model.covariance * INTERVALS[words] ** 2)
        found = {name: tried(narrower, name) for name in (PILOTS if INTERVALS[words] == 1.0 else ("regulator",))}
        shares = {WHO[name]: one["held"] for name, one in found.items()}
        if len(found) > 1:
            shares["regulator with the true coefficients"] = found["regulator"]["known"]
            shares["course within the reserve"] = found["regulator"]["holds"]
        for who, share in shares.items():
            percents = (f"{100 * float(share.sel(y=offset)[0]):.0f} %" for offset in HELD_AT)
            who = who if INTERVALS[words] == 1.0 else f"{who}, intervals {words}"
            rows.append((who, *percents, edge(share)))
    heads = "pilot", *(f"at {offset:g} m" for offset in HELD_AT), "95 % held out to [m]"
    return markdown(heads, rows)


def tried(model: nw.Model, pilot: str) -> xr.Dataset:
    """What a pilot holds, port and starboard alike, so one side is tried."""
    offsets, speed = np.arange(0.0, 21.0, 1.0), np.array([10 * KNOT])
    return nw.safe_envelope(model, offsets, speed, samples=TRIED, controller=pilot).data


def edge(share: xr.DataArray) -> str:
    """How far off the middle a share stays 19 of 20, straight between the offsets tried."""
    y, shares = share["y"].to_numpy(), share.to_numpy()[:, 0]
    if shares[0] < SURE_SHARE:
        return "nowhere"
    last = int(np.flatnonzero(shares < SURE_SHARE)[0]) - 1 if (shares < SURE_SHARE).any() else len(y) - 1
    return f"{crossing(y, shares, last, last + 1, SURE_SHARE):.0f}" if last + 1 < len(y) else f"{y[-1]:.0f} and on"


def said(angle: float, limit: float) -> str:
    """An angle, or that it is beyond the gear."""
    return f"{angle:+.1f}" if abs(angle) <= limit else "beyond the gear"


def text(intervals: tuple[str, ...] = tuple(INTERVALS)) -> str:
    """Four tables, the last for some intervals."""
    hulls = measured()
    kcs = {f"KCS, {CLEARANCES[label]}": model for label, model in hulls.items()}
    dtc = published()
    borrowed = {"DTC as published, rudder of the KCS": nw.borrow_rudder(dtc, hulls["C0101A02"])}
    tables = (
        water(),
        adrift({"DTC as published": dtc, **kcs}),
        steered({**borrowed, **kcs}),
        held(hulls["C0101A02"], intervals),
    )
    return "\n\n".join(tables)


def figure() -> Figure:
    """The envelope of the KCS at 50 %, on which the depth over the draft is the canal's."""
    return nw.safe_envelope(measured()["C0101A02"], np.linspace(-40, 40, 33), bank="sloping").plot()


if __name__ == "__main__":
    publish(__file__, "suez.md", text())
