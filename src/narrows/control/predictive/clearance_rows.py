"""Room between the hull's corners and the banks, as rows of a quadratic program."""

import numpy as np

from narrows.control.predictive.line_frame import HELD

# Of the hull's rectangle: half lengths forward, half beams to starboard.
CORNERS = ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))
FORWARD, SIDES = np.array(CORNERS).T[:, :, None]


def corner_offsets(
    states: np.ndarray, half_length: float, half_beam: float, curvature: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Return where corners are off the line, what that changes by the heading, and how far ahead they are."""
    # states (nodes, 5); half_length, half_beam [m]; curvature (nodes,) [1/m]
    # In a bend the line falls away from what is ahead and astern by half its curvature times the distance squared.
    forward, aside = half_length * FORWARD, half_beam * SIDES
    sine, cosine = np.sin(states[:, 1]), np.cos(states[:, 1])
    ahead = forward * cosine - aside * sine
    across = forward * sine + aside * cosine
    off = states[:, 0] + across - curvature * ahead**2 / 2
    return off, ahead + curvature * ahead * across, ahead


def clearance_rows(
    corners: tuple[np.ndarray, np.ndarray], e: np.ndarray, G: np.ndarray, room: tuple[np.ndarray, np.ndarray],
    spare: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return rows and bounds: rows @ change of the rates <= bounds keeps every corner off the banks."""
    # corners (4, nodes) [m]; e, G (nodes, 5); room (4, nodes) [m]; spare [m]
    off, lever = corners
    y, psi = HELD.index("y"), HELD.index("psi")
    now = SIDES * (off + e[:, y] + lever * e[:, psi])
    bounds = np.where(SIDES > 0, room[0], room[1]) - now
    corner, node = np.nonzero(~(bounds > spare))  # what is no number among them, for a program to refuse
    rows = SIDES[corner] * (G[node, y] + lever[corner, node, None] * G[node, psi])
    return rows, bounds[corner, node]
