"""``envelope``: how fast, and how far off the centreline, a ship stays controllable."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import narrows as nw
from narrows.base.errors import InputError
from narrows.cli.options import Argument, DatasetDelivery, Numbers, Speed, Speeds, numbers, verb
from narrows.cli.voyages import CurrentText
from narrows.empirical.fleet import model_named
from narrows.safety.settings import SAMPLES

# Number of places of ``--along all``.
ALONG_PLACES = 11
# Speed of a gust of a minute over the mean of an hour [1], Durst (1960), from memory, not verified.
GUST_FACTOR = 1.24


@dataclass(frozen=True)
class SectionOptions:
    width: Annotated[float | None, "Width of the canal [m]; default: the model's own."] = None
    depth: Annotated[float | None, "Depth of the canal [m], likewise."] = None
    waterway: Annotated[Path | None, "GeoJSON of a waterway, whose section replaces the model's canal."] = None
    at: Annotated[float, "Place along the waterway [m]."] = 0.0
    along: Annotated[str | None, "Places along the waterway instead [m]: all, or 0:5000:11."] = None
    current: CurrentText = None
    level: Annotated[float, "Water level above that of the depths [m]."] = 0.0

    def read(self) -> "nw.Waterway":
        assert self.waterway is not None
        return nw.read_waterway(self.waterway).with_water(self.current, self.level)

    def places(self, waterway: "nw.Waterway") -> list[float]:
        """Return the places of ``--along`` [m]: ``all`` are evenly spaced from end to end."""
        everywhere = f"0:{waterway.line.length}:{ALONG_PLACES}"
        return list(numbers("--along", everywhere if self.along == "all" else str(self.along)).tolist())

    def placed(self, model: "nw.Model") -> "tuple[nw.Model, dict[str, Any], tuple[str, ...]]":
        """Return the model there, what the envelope is asked of the place, and notes on the place."""
        if self.waterway is None:
            return model, {}, ()
        from narrows.safety.envelope_along import reach_at
        from narrows.simulation.outcome import water_notes

        waterway = self.read()
        if not 0 <= self.at <= waterway.line.length:
            raise InputError(f"--at {self.at:g} is beyond the waterway, which is {waterway.line.length:.0f} m long")
        reach = reach_at(model, waterway, self.at)
        sentence = (
            f"at {self.at:.0f} m along {waterway.name}: the middle is {reach.middle:+z.1f} m off its centreline, "
            "starboard positive"
        )
        return reach.model, reach.asked, (sentence, *water_notes(waterway, model.configuration.canal.depth))


@dataclass(frozen=True)
class WeatherOptions:
    heading_deg: Annotated[float, "Heading error at the start, standard deviation [deg]."] = 2.0
    wind: Annotated[Speed, "Speed of a steady beam wind, from either side: 10m/s, 20kn."] = "0m/s"
    gusts: Annotated[float, "Ratio of gust to wind speed [1]; 1 for none."] = GUST_FACTOR
    windage: Annotated[float, "Lateral area above the water [m2], with --wind."] = 0.0
    gust_lever: Annotated[float, "Lever of wind and gust, forward of midship [m]."] = 0.0
    gust_time: Annotated[float, "Duration of the gust [s]."] = 60.0

    def disturbance(self) -> "nw.Disturbance":
        if not 1 <= self.gusts < 10:
            raise InputError(f"--gusts {self.gusts:g}: a gust is as fast as the wind or faster; give 1 to 10")
        steady = nw.wind_force(self.wind, self.windage)
        return nw.Disturbance(
            self.heading_deg, gust=(self.gusts**2 - 1) * steady, gust_lever=self.gust_lever, gust_time=self.gust_time,
            wind=self.wind or None, steady=steady,
        )  # fmt: skip


OWN_SIZE = "Model file at the ship's own size (see scale), with a rudder, or a ship's name; none with --demo."
# A ship with a rudder and banks, but untested, which the chart notes.
DEMO_SHIP = "estimated_kcs"


@verb(
    "narrows envelope full.toml --speed 4kn:12kn:17 --plot chart.png -o envelope.nc",
    needs={"at along current level": "waterway", "wind": "windage", "windage": "wind"}, one=("model demo",),
    apart=("at along", "width waterway", "depth waterway"),
)  # fmt: skip
def envelope(
    *,
    y: Annotated[Numbers | None, "Offsets from the middle [m]: a,b,c or from:to:count; default: bank to bank."] = None,
    speed: Annotated[Speeds | None, "Speeds through the water: 8kn, 4kn:12kn:17, 4.1m/s; default: to choking."] = None,
    section: SectionOptions,
    weather: WeatherOptions,
    delivery: DatasetDelivery,
    reserve: Annotated[float, "Share of the rudder left on the steady course."] = 1 / 3,
    keel: Annotated[float | None, "Least clearance under the keel [m]; default: a twentieth of the draft."] = None,
    samples: Annotated[int, "Number of samples."] = SAMPLES,
    seed: Annotated[int, "Seed of the samples."] = 0,
    controller: Annotated[str, "Pilot, such as regulator or human; an unknown name lists all."] = "regulator",
    bank: Annotated[str, "Kind of bank for design rules: gentle, sloping or steep."] = "steep",
    rudder_of: Annotated[str | None, "Model whose rudder is used if this one has none."] = None,
    demo: Annotated[bool, "Use estimated_kcs, 230 m, in a canal of 300 x 16.2 m."] = False,
    model: Annotated[str | None, Argument(help=OWN_SIZE)] = None,
) -> None:
    """Find the safe speeds and offsets of a ship in a canal.

    The answer is a table and a chart; see docs/safe-envelope.md.
    """
    from narrows.report.envelope_chart import print_envelope, print_envelope_along
    from narrows.safety.result import noting

    disturbance, ship = weather.disturbance(), model_named(model or DEMO_SHIP, section.width, section.depth)
    ship = nw.borrow_rudder(ship, model_named(rudder_of)) if rudder_of else ship
    asked: dict[str, Any] = {
        "y": y, "u": speed, "disturbance": disturbance, "reserve": reserve, "keel": keel, "samples": samples,
        "seed": seed, "bank": bank, "controller": controller, "progress": sys.stderr.isatty() and not delivery.json,
    }  # fmt: skip
    if section.along is not None:
        waterway = section.read()
        along = nw.envelope_along(ship, waterway, section.places(waterway), **asked)
        delivery.give(along, print_envelope_along)
        raise SystemExit(int(bool(along.to_dataframe()["highest_speed"].isna().all())))
    ship, reach, notes = section.placed(ship)
    result = noting(nw.safe_envelope(ship, **asked, **reach), *notes)
    delivery.give(result, print_envelope)
    raise SystemExit(int(bool(result.highest_speed().isnull().all())))
