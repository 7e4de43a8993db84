"""Words of the README, the docs and the source: British spelling, and no turn that a reader has to read twice."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
AMERICAN = r"\b(?:behavior|center|modeling|neighbor|analyze|color|gray|maneuver\w*|meters?|traveled|labeled)\b"
# Turns that are not used.
TURNS = (
    r"\(ours\)", r"\bwherefrom\b", r"\bnineteen cases\b", r"\bgoes by\b", r"\bforetell\w*", r"\bas it stands\b",
    r"\bbrought to\b", r"\bheld to\b", r"\bin doubt\b",
    r"\b(?:tests|data|runs|logs?|gauges?|rudders?) (?:say|tell|know|hear|feel|teach)s?\b",
)  # fmt: skip


def found(pattern: str) -> list[str]:
    """The lines of prose that have a pattern: code between backticks and fences is none."""
    lines = []
    for page in PAGES:
        text = re.sub(r"```.*?```|`[^`]*`|^:::.*$|\{[^}]*\}", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)
        lines += [f"{page.name}: {line.strip()}" for line in text.splitlines() if re.search(pattern, line)]
    return lines


def test_spelling_is_british() -> None:
    assert found(AMERICAN) == []


@pytest.mark.parametrize("turn", TURNS)
def test_no_turn_is_read_twice(turn: str) -> None:
    assert found(turn) == []


# Descriptions in the source without a subject, and data that speak or think: how many are left.
THINGS = r"(?:data|tests?|runs?|logs?|records?|gauges?|rudders?|sensors?|motions?|models?|fits?|tables?)"
IN_SOURCE = {
    r'(?:"""|# (?:\([^)]*\) )?|^ +)(?:Of|Wherefrom|Say (?:it|them))\b(?! course)': 1,
    r'"""(?:What|How|Which|Why|That)\b(?! to )': 1,
    rf"\b{THINGS} (?:(?:do not|does not|cannot) )?(?:say|tell|know|hear|feel|teach|think|believe|speak)s?\b": 0,
}


@pytest.mark.parametrize("turn", IN_SOURCE)
def test_descriptions_have_a_subject(turn: str) -> None:
    texts = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "src").rglob("*.py"))]
    lines = [line.strip() for text in texts for line in text.splitlines() if re.search(turn, line)]
    assert len(lines) <= IN_SOURCE[turn], lines


# Words that a reader of the field searches for; each stands in the source and in the docs.
TERMS = (
    "added mass", "anti-windup", "automatic differentiation", "bank cushion", "bank suction", "blockage", "bootstrap",
    "bow-out", "captive test", "condition number", "covariance", "credible interval", "cross-validation",
    "crossflow drag", "delay margin", "drift angle", "Fisher scoring", "Froude", "Gauss-Markov",
    "generalised least squares", "hidden Markov", "hydrodynamic derivative", "importance sampling", "innovation",
    "jackknife", "Karush-Kuhn-Tucker", "Laplace approximation", "line-of-sight guidance",
    "linear-quadratic regulator", "model predictive control", "Monte Carlo", "multiple shooting", "NEES", "Nomoto",
    "optimal experiment design", "planar motion mechanism", "restricted maximum likelihood", "return flow", "Riccati",
    "Runge-Kutta", "Schijf", "sequential quadratic programming", "Shapley value", "sigma point", "smoother", "squat",
    "state-space", "straight-line program", "system identification", "thrust deduction", "under-keel clearance",
    "unscented Kalman filter", "variance inflation", "wake fraction", "zigzag",
)  # fmt: skip


def test_terms_of_the_field_are_found_by_a_search() -> None:
    source = sorted((ROOT / "src").rglob("*.py"))
    for pages in (PAGES, source):
        text = " ".join(" ".join(path.read_text(encoding="utf-8").split()) for path in pages).lower()
        assert [term for term in TERMS if term.lower() not in text] == []
