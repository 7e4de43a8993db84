"""One transit of a ship whose model is estimated from four numbers: twins whose truth comes from other formulas.

python decisions/estimated_twins.py [--write] [--twins 80] [--kept FOLDER]

Each true derivative is one formula of the registry, drawn at random; the bank is one row of the evidence whose error is
smaller than the spread within a ship; rudder, propeller and resistance are drawn from the estimate. Ships that a pilot
who knows them does not bring through in the gusts are not counted.
"""

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from bank_evidence import BANK_EVIDENCE, bank_effects
from pages import markdown, publish

import narrows as nw
from narrows.empirical.formulas import FORMULAS, depth_factor
from narrows.empirical.main_dimensions import hull_of
from narrows.logbook.ship_log import VDR
from narrows.logbook.steady_legs import usual_offsets
from narrows.logbook.transits import TransitTwin
from narrows.quantities.names import KNOT

sys.path.append(str(Path(__file__).parent.parent / "tests"))
from twins import drawn_truth, transits_of

SPEED, MINUTES, TWINS = 8 * KNOT, 20.0, 80
BANKS, HULL = ("Y_bank", "N_bank"), ("X_my", "N_jz", "Y_v", "N_v", "Y_r", "N_r")
NAMES = (*BANKS, *HULL)
CONDITIONS = nw.TransitConditions(wander=10.0)
"""A canal 300 m wide with meetings: the aim wanders by 10 m, not by 3."""


def safe_offset(model: nw.Model, u: float) -> float:
    """How far off the middle a quick safe envelope lets a ship go [m]."""
    offsets = np.append(0.0, usual_offsets(model))
    safe = nw.safe_envelope(model, offsets, np.array([u]), samples=200).by_model().to_numpy()[:, 0]
    return float(offsets[int(np.argmin(safe)) - 1]) if safe[0] and not safe.all() else float(offsets[-1] * safe[0])


def estimated() -> nw.Model:
    """The KCS from four numbers, in 300 x 16.2 m, with the revolutions of the transit's speed."""
    ship = nw.Ship(length=230, beam=32.2, draft=10.8, block_coefficient=0.651, name="KCS")
    return nw.estimate_model(ship, nw.Canal(300, 16.2), speed=SPEED)


def true_ship(prior: nw.Model, seed: int) -> nw.Model:
    """Draw a formula for each derivative, and a row of the evidence for the bank."""
    draw, configuration = np.random.default_rng((seed, 19)), prior.configuration
    hull, depth = hull_of(configuration.ship), configuration.canal.depth / configuration.ship.draft
    values = {}
    for name in dict.fromkeys(formula.coefficient for formula in FORMULAS):
        formulas = [formula for formula in FORMULAS if formula.coefficient == name]
        chosen = formulas[draw.integers(len(formulas))]
        values[name] = float(chosen.law(hull)) * depth_factor(name, hull, depth)
    spread = bank_effects()["Y_bank"].within
    rows = [(row.suction, row.cushion) for row in BANK_EVIDENCE if row.cushion and row.suction_error < spread]
    values["Y_bank"], values["N_bank"] = rows[draw.integers(len(rows))]
    values |= {other: values[one] for one, other in prior.terms.ties if one in values}
    return drawn_truth(prior, seed, **values)


def figures(prior: nw.Model, seed: int) -> dict[str, Any]:
    """Return what one transit of a true ship gives; nothing where the ship does not come through."""
    truth = true_ship(prior, seed)
    try:
        log = transits_of(TransitTwin(truth, SPEED, 60 * MINUTES, CONDITIONS), VDR, 1, seed)
    except nw.InputError:
        return {}
    fit, stds = nw.learn(prior, log, sensors=VDR), _stds(prior)
    return {
        "before": [_held(truth[name], prior[name], stds[name]) for name in NAMES],
        "after": [_held(truth[name], fit.model[name], fit.std[name]) for name in NAMES],
        "left": [fit.std[name] / stds[name] for name in NAMES],
        "offset": safe_offset(fit.model, SPEED),
    }


def _stds(model: nw.Model) -> dict[str, float]:
    return dict(zip(model.terms.names, np.sqrt(np.diag(model.covariance)), strict=True))


def _held(truth: float, value: float, std: float) -> bool:
    return bool(abs(truth - value) <= 1.96 * std)


def kept_figures(prior: nw.Model, count: int, folder: Path) -> list[dict[str, Any]]:
    """Return the figures of so many twins, those that are kept first."""
    folder.mkdir(parents=True, exist_ok=True)
    found: list[dict[str, Any]] = []
    seed = 0
    while len(found) < count:
        seed += 1
        path = folder / f"{seed}.json"
        one = json.loads(path.read_text()) if path.exists() else figures(prior, seed)
        path.write_text(json.dumps(one))
        found += [one] if one else []
    return found


def text(count: int, folder: Path) -> str:
    """The table: coverage before and after the transit, what is left of the spread, and the safe offset."""
    prior = estimated()
    twins = kept_figures(prior, count, folder)
    offsets = [twin["offset"] for twin in twins]
    left = np.median([twin["left"] for twin in twins], axis=0)
    spread = f"{np.median(offsets):.0f} ({min(offsets):.0f} to {max(offsets):.0f})"
    rows = [
        _row("estimate", twins, "before", ("1", "1", f"{safe_offset(prior, SPEED):.0f}")),
        _row("after one transit", twins, "after", (f"{left[0]:.2f}", f"{left[1]:.2f}", spread)),
    ]
    heads = (
        "model", "b_bank covered", "c_bank covered", "hull covered", "standard error of b_bank over the estimate's",
        "of c_bank", "safe offset at 8 knots [m]",
    )  # fmt: skip
    return f"{count} twins; for the safe offset median and range:\n\n{markdown(heads, rows)}"


def _row(name: str, twins: list[dict[str, Any]], key: str, rest: tuple[str, ...]) -> tuple[str, ...]:
    held = np.array([twin[key] for twin in twins])
    shares = (held[:, 0].mean(), held[:, 1].mean(), held[:, 2:].mean())
    return (name, *(f"{100 * share:.0f} %" for share in shares), *rest)


if __name__ == "__main__":
    options = dict(zip(sys.argv[1:], sys.argv[2:], strict=False))
    with TemporaryDirectory() as temporary:
        kept = Path(options.get("--kept", temporary))
        publish(__file__, "tutorials/estimate.md", text(int(options.get("--twins", TWINS)), kept))
