"""The learned law of a helmsman against a textbook filter, one ship and one delay at a time, and the law's formulas."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import t as student

from narrows.warning.forecasting.helmsman import Helmsmen, LineOfSight, Manoeuvre, escape_numbers, log_student

LENGTH = 230.0
DELAYS = (0, 4, 8, 12)  # [s]
MEMORY = 300.0  # [s]


class OneHelmsman:
    """A Kalman filter of four gains for each delay (Bar-Shalom) and Bayes' rule for an empty helm, in scalars."""

    def __init__(self) -> None:
        sigma = np.diag([0.1, 0.5, 1.0, 1.0]) ** 2
        self.mean = [np.array([0.0, 0.5, 1.5, 1.0]) for _ in DELAYS]
        self.covariance = [sigma.copy() for _ in DELAYS]
        self.walk = sigma / MEMORY
        self.square = [0.07**2] * 4
        self.past: list[np.ndarray] = []
        self.chance, self.held, self.limit = 0.02, math.nan, 0.17

    def update(self, y: float, psi: float, turn: float, u: float, rudder: float) -> None:
        self.past.append(np.array([1.0, -y / LENGTH, -psi, -turn * LENGTH / max(u, 0.1)]))
        rows = [self.past[max(len(self.past) - 1 - delay, 0)] for delay in DELAYS]
        off = [rudder - float(row @ gains) for row, gains in zip(rows, self.mean, strict=True)]
        best = int(np.argmin(self.square))
        self.off = off[best]
        self.chance = self._chance(rudder, math.sqrt(self.square[best]))
        attended = 1.0 - self.chance
        for k, row in enumerate(rows):
            self.covariance[k] = self.covariance[k] + self.walk
            noise = 10.0 * self.square[k] / max(attended, 1e-3)  # ten seconds are one piece of evidence
            gain = self.covariance[k] @ row / (row @ self.covariance[k] @ row + noise)
            self.mean[k] = self.mean[k] + gain * off[k]
            self.mean[k][1:] = np.maximum(self.mean[k][1:], 0.0)
            self.covariance[k] = (np.eye(4) - np.outer(gain, row)) @ self.covariance[k]
            self.square[k] += attended / MEMORY * (max(off[k] ** 2, 0.035**2) - self.square[k])
        self.limit = max(self.limit * math.exp(-1.0 / MEMORY), abs(rudder), 0.17)

    def _chance(self, rudder: float, scatter: float) -> float:
        """Markov chain (a lapse an hour, a return a minute), densities of Student's t, and moves of the rudder."""
        self.held = rudder if math.isnan(self.held) else self.held
        step = rudder - self.held
        moved = abs(step) > 0.02
        nearer = abs(self.off) < abs(self.off - step)
        self.held = rudder if moved else self.held
        before = self.chance * (1 - 1 / 60.0) + (1 - self.chance) / 3600.0
        ratio = student.pdf(self.off, 3.0, scale=0.2) / student.pdf(self.off, 3.0, scale=scatter)
        odds = before / (1 - before) * float(ratio) ** 0.25
        odds *= 0.02 * 10.0 if moved and nearer else 1.0
        return min(max(odds / (1 + odds), 1e-4), 0.999)


def swings(ship: int, seconds: int = 330) -> list[tuple[float, float, float, float, float]]:
    """A swinging ship; a hand that answers at once or 8 s late, and then puts the rudder over and lets go for 100 s."""
    rows, rudder, past = [], 0.0, []
    for t in range(seconds):
        phase = 2 * math.pi * t / (70.0 + 20 * ship)
        y, psi, turn = 15.0 * math.sin(phase / 2), 0.06 * math.sin(phase), 0.004 * math.cos(phase)
        u = 4.5 - ship
        past.append(0.02 - 0.7 * y / LENGTH - (2.0 - ship) * psi - 0.6 * turn * LENGTH / u)
        if t % 2 == 0 and not 200 <= t < 300:
            rudder = past[max(t - 8 * ship, 0)]
        rudder = 0.35 if t == 200 else rudder
        rows.append((y, psi, turn, u, 0.3 if ship and t == 150 else rudder))
    return rows


def test_gains_and_the_chance_of_an_empty_helm_are_those_of_a_textbook_filter() -> None:
    """Two ships at once, each against its own filter: gains, deviation, chance, angles that are used, and law."""
    both, each = Helmsmen(2, LENGTH), (OneHelmsman(), OneHelmsman())
    chances = []
    for rows in zip(swings(0), swings(1), strict=True):
        both.update(*np.array(rows).T)
        for one, row in zip(each, rows, strict=True):
            one.update(*row)
        np.testing.assert_allclose(both.unattended, [one.chance for one in each], rtol=1e-6)
        np.testing.assert_allclose(both.off, [one.off for one in each], atol=1e-9)
        np.testing.assert_allclose(both.limit, [one.limit for one in each], rtol=1e-12)
        chances.append(both.unattended.copy())
    np.testing.assert_allclose(both.gains, [one.mean for one in each], atol=1e-9)
    best = [int(np.argmin(one.square)) for one in each]
    assert best[0] != best[1]
    law = both.law(np.array([4.5, 0.05]))
    for k, (one, own) in enumerate(zip(each, best, strict=True)):
        trim, by_y, by_psi, by_r = one.mean[own]
        expected = {
            "since": DELAYS[own] + 5.0, "trim": trim, "by_psi": by_psi, "line": 0.0, "reach": by_y / LENGTH / by_psi,
            "by_r": by_r * LENGTH / (4.5, 0.1)[k], "most": one.limit,
        }  # fmt: skip
        assert {name: value[k] for name, value in law.items()} == pytest.approx(expected, rel=1e-9)
    assert max(chances[290]) > 10 * max(chances[195])


def test_a_law_without_heading_divides_by_no_zero() -> None:
    """The least gain of the heading is 0.05; the offset then counts over it."""
    one = Helmsmen(1, LENGTH)
    one.gains[...] = [0.01, 0.4, 0.0, 0.5]
    law = one.law(np.array([4.0]))
    assert law["by_psi"] == [0.05]
    assert law["reach"] == pytest.approx([0.4 / LENGTH / 0.05])
    assert law["since"] == [5.0]


def test_log_densities_are_those_of_students_t() -> None:
    off, scale = np.array([0.0, 0.1, -0.5]), np.array([0.04, 0.2, 0.1])
    expected = student.logpdf(off, 3.0, scale=scale) - student.logpdf(0.0, 3.0)
    np.testing.assert_allclose(log_student(off, scale), expected, rtol=1e-12)


def at(t: float = 20.0, **changed: float) -> SimpleNamespace:
    """A ship 30 m off its line that turns, in a bend and a current, by the numbers of a law."""
    numbers = {
        "u": 4.0, "current": 0.5, "psi": 0.02, "crab": 0.01, "line": 10.0, "y": 40.0, "reach": 0.001, "approach": 0.05,
        "r": 0.003, "trim": 0.02, "by_psi": 1.5, "by_r": 40.0, "most": 0.4, "since": 15.0, "dt": 1.0, "ordered": -0.2,
        "kicked": 3.0, "turns": 2.0, "x": 100.0,
    }  # fmt: skip
    return SimpleNamespace(t=t, water=lambda name, x: {"curvature": x / 500_000.0}[name], **{**numbers, **changed})


def test_guidance_by_line_of_sight_orders_what_its_formula_gives() -> None:
    """By hand: the course is -0.03, the heading 0.06 off it, the turn 0.003 - 0.0002 x 4.5 off the bend's."""
    law = LineOfSight()
    by_hand = 0.02 - 1.5 * (0.02 + 0.01 + 0.03) - 40.0 * (0.003 - 0.0009)
    assert law.orders(at())[0]["rudder"] == pytest.approx(by_hand)
    far = 0.02 - 1.5 * (0.03 + 0.05) - 40.0 * 0.0021
    assert law.orders(at(y=140.0))[0]["rudder"] == pytest.approx(far)
    assert law.orders(at(y=-140.0))[0]["rudder"] == pytest.approx(0.02 - 1.5 * (0.03 - 0.05) - 40.0 * 0.0021)
    assert law.orders(at(psi=1.0))[0]["rudder"] == -0.4
    assert law.orders(at(t=14.5))[0]["rudder"] == -0.2
    assert law.orders(at(t=15.0))[0]["rudder"] == pytest.approx(by_hand)
    assert set(law.orders(at())[0]) == {"rudder"}


def test_a_kick_orders_revolutions_from_the_takeover_on() -> None:
    law = LineOfSight(driven=True)
    assert law.orders(at())[0]["revolutions"] == 3.0
    assert law.orders(at(t=14.0))[0]["revolutions"] == 2.0
    assert {"turns", "kicked"} == set(law.parameters()) - set(LineOfSight().parameters())
    assert Manoeuvre("as it is").kick == 1.0


def test_an_escape_meets_its_line_three_lengths_ahead_with_three_times_the_heading() -> None:
    assert escape_numbers(5.0, 200.0, 0.6) == pytest.approx(
        {"line": 5.0, "reach": 1 / 600.0, "approach": 0.05, "trim": 0.0, "most": 0.6, "by_psi": 3.0, "by_r": 600.0}
    )
