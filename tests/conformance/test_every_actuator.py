"""Every actuator of ``STANDARD``: its sections, its place in the terms, its scaling, and how it follows its orders."""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import narrows as nw
from narrows.model import sections as model_files
from narrows.quantities.names import PARTICULARS, Dimension, dimension_of
from narrows.ship import actuators, ship_file
from narrows.ship.actuators import MODEL_SECTIONS, SHIP_SECTIONS, STANDARD, Actuator, Part, number_in, with_standard

every_actuator = pytest.mark.parametrize("actuator", STANDARD, ids=lambda own: own.name)
LIMIT, RATE, STEP = 0.3, 0.1, 0.5


def sections(actuator: Actuator) -> list[Part]:
    """Its sections of a ship file, every number a half, and one pump."""
    return [part(**{own.name: 1 if own.name == "pumps" else 0.5 for own in fields(part)}) for part in actuator.parts]


def test_no_actuator_and_no_section_is_forgotten() -> None:
    own = [one for one in vars(actuators).values() if isinstance(one, Actuator)]
    assert sorted(one.name for one in own) == sorted(one.name for one in STANDARD)
    parts = {one for one in vars(actuators).values() if isinstance(one, type) and issubclass(one, Part)} - {Part}
    assert parts == {part for actuator in STANDARD for part in actuator.parts}


def test_sections_of_files_that_are_of_no_actuator_cannot_be_one() -> None:
    other = {*SHIP_SECTIONS, *MODEL_SECTIONS}
    assert {*ship_file.NEEDED, *model_files.REQUIRED} <= other
    for section in ("", *other):
        own = type("Own", (Part,), {"SECTION": section, "POSITION": "flap"})
        with pytest.raises(nw.InputError, match=rf"section \[{section}\] has another meaning in ship and model files"):
            Actuator("flap", "rad", "angle of the flap", parts=(own,))


@every_actuator
def test_another_of_its_name_or_section_is_refused(actuator: Actuator) -> None:
    assert with_standard([actuator]) == STANDARD
    with pytest.raises(nw.InputError, match=f"two actuators are called '{actuator.name}'; rename one"):
        nw.Term("b_own", "b", lambda u: u, nw.Dimension(), actuator=replace(actuator, meaning="another"))
    section = actuator.parts[0].SECTION
    flap = Actuator("flap", "1", "angle of the flap", parts=(section_of("flap", section),))
    with pytest.raises(nw.InputError, match=f"two sections are called '{section}'; rename one"):
        with_standard([flap])


def section_of(actuator: str, section: str) -> type[Part]:
    """A section with a size and a limit."""

    @dataclass(frozen=True)
    class Own(Part):
        SECTION: ClassVar[str] = section
        POSITION: ClassVar[str] = actuator
        size: float = number_in("m", "size", 0.5)
        limit: float = number_in("1", "largest position", 0.5)

    return Own


def term_of(actuator: Actuator) -> nw.Term:
    law = eval(f"lambda {actuator.name}: {actuator.name}")
    return nw.Term(f"b_{actuator.name}", "b", law, nw.Dimension(1, 1, -2), actuator=actuator)


def test_one_number_in_two_sections_is_refused() -> None:
    """The limit is that of the position: two sections cannot have one each."""
    parts = section_of("flap", "flap"), section_of("flap", "gear")
    with pytest.raises(nw.InputError, match="two numbers of flap are called 'flap_limit'; rename one"):
        Actuator("flap", "1", "angle of the flap", parts=parts)


def test_two_actuators_of_one_section_are_refused_in_a_table() -> None:
    """Before a model of it is saved, which could not be read again."""
    terms = [term_of(Actuator(name, "1", "position", parts=(section_of(name, "gear"),))) for name in ("flap", "fin")]
    with pytest.raises(nw.InputError, match="two sections are called 'gear'; rename one"):
        nw.PAPER.with_terms("own", sway=terms)


def test_a_section_may_have_the_name_of_a_property(dtc: nw.Model, tmp_path: Path) -> None:
    """And is a section of its own class, which another may derive from."""
    base = section_of("flap", "gear")
    own = type("Stern", (base,), {"SECTION": "parts", "POSITION": "fin"})
    terms = [term_of(Actuator(part.POSITION, "1", "position", parts=(part,))) for part in (base, own)]
    table = nw.PAPER.with_terms("own", sway=terms)
    configuration = dtc.configuration.with_parts([base(), own(size=2.0)])
    model = nw.Model(configuration, table, {**dtc.coefficients, "b_flap": 1.0, "b_fin": 1.0})
    nw.save_model(model, tmp_path / "own.toml")
    again = nw.load_model(tmp_path / "own.toml", terms=table).configuration
    assert (again.parts["gear"].size, again.parts["parts"].size) == (0.5, 2.0)
    assert again.values()["fin_limit"] == 0.5


def test_an_angle_is_in_radians() -> None:
    with pytest.raises(nw.InputError, match="actuator flap: an angle in deg; give it in rad"):
        Actuator("flap", "deg", "angle of the flap", angle=True)


def test_a_section_without_numbers_is_refused() -> None:
    part = type("Flap", (Part,), {"SECTION": "flap", "POSITION": "flap"})
    with pytest.raises(nw.InputError, match=r"section \[flap\] has no numbers; make Flap a frozen dataclass"):
        Actuator("flap", "rad", "angle of the flap", parts=(part,))


@every_actuator
def test_its_sections_give_the_unit_of_every_number(actuator: Actuator) -> None:
    for part in actuator.parts:
        assert all(quantity.meaning for quantity in part.numbers().values())
    for quantity in (*actuator.quantities.values(), *PARTICULARS.values()):
        assert isinstance(dimension_of(quantity.unit), Dimension)


@every_actuator
def test_a_position_gives_the_terms_what_they_ask_for(actuator: Actuator) -> None:
    assert actuator.placed(0.2).keys() == actuator.controls.keys()
    assert actuator.at_rest() == ({} if actuator.rest is None else actuator.placed(actuator.rest))


@every_actuator
def test_its_sections_go_into_files_and_back(actuator: Actuator, dtc: nw.Model, tmp_path: Path) -> None:
    parts = sections(actuator)
    model = replace(dtc, configuration=dtc.configuration.with_parts(parts))
    nw.save_model(model, tmp_path / "ship.toml")
    again = nw.load_model(tmp_path / "ship.toml").configuration
    assert again == model.configuration
    assert [again.parts[part.SECTION] for part in parts] == parts


@every_actuator
def test_its_numbers_scale_by_their_dimensions(actuator: Actuator) -> None:
    for own in sections(actuator):
        large = own.scaled(lambda dimension: 4.0**dimension.length * 2.0**dimension.time)
        for name, quantity in own.numbers().items():
            unit = dimension_of(quantity.unit)
            expected = getattr(own, name) * 4.0**unit.length * 2.0**unit.time
            assert getattr(large, name) == pytest.approx(expected), name


@dataclass(frozen=True)
class Ordered:
    """A law that orders one position, of any actuator."""

    name: str
    position: float

    def parameters(self) -> dict[str, float]:
        return {"position": self.position}

    def memory(self, start: Any) -> dict[str, float]:
        return {}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, float]]:
        return {self.name: at.position}, {}


def moved_by(actuator: Actuator, dtc: nw.Model) -> nw.Model:
    """The published hull with a sway force in proportion to the position, and a gear with a limit and a rate."""

    @dataclass(frozen=True)
    class Gear(Part):
        SECTION: ClassVar[str] = f"gear_of_{actuator.name}"
        POSITION: ClassVar[str] = actuator.name
        limit: float = LIMIT
        rate: float = RATE

    (*_, control) = actuator.controls
    force = eval(f"lambda {control}: {control}")
    term = nw.Term("b_moved", "b_{moved}", force, nw.Dimension(1, 1, -2), actuator=actuator)
    table = nw.PAPER.with_terms("moved", sway=[term])
    prompt = {"dead_time": 0.0, "lag": 0.0, "dead_band_deg": 0.0}
    parts = [replace(part, **prompt) if isinstance(part, nw.SteeringGear) else part for part in sections(actuator)]
    configuration = dtc.configuration.with_parts([*parts, Gear()])
    return nw.Model(configuration, table, {**dtc.coefficients, "b_moved": 5.0})


@every_actuator
@pytest.mark.parametrize("side", [1, -1])
def test_it_follows_an_order_at_its_rate_up_to_its_limit(actuator: Actuator, side: int, dtc: nw.Model) -> None:
    """In a voyage and in a fleet: a ramp of ``RATE``, held at ``LIMIT``, or where an order is nearer, there."""
    model = moved_by(actuator, dtc)
    told = {actuator.name: 0.0, "u": 0.8, "duration": 10 * STEP, "dt": STEP}
    for order in (1.0, 0.12):
        law = Ordered(actuator.name, side * order)
        voyage = nw.simulate(model, controller=law, **told)
        np.testing.assert_allclose(voyage[actuator.name], side * np.minimum(RATE * voyage.t, min(order, LIMIT)))
        fleet = nw.ensemble(model, controller=law, y=[0.0, 0.1], **told)
        assert float(fleet["v_end"][0]) == pytest.approx(voyage.v[-1], abs=1e-12)
