"""The command line: one thin command a verb, a file for those that belong together."""

from narrows.cli import envelopes, fits, learning, models, plans, ready_ships, voyages, watching, waterways
from narrows.cli.app import app, main

__all__ = [
    "app", "envelopes", "fits", "learning", "main", "models", "plans", "ready_ships", "voyages", "watching",
    "waterways",
]  # fmt: skip
