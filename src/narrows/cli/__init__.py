"""The command line: one thin command a verb, a file for those that belong together."""

from narrows.cli import envelopes, exporting, fits, learning, plans, scale, voyages, watching, waterways
from narrows.cli.app import app, main

__all__ = [
    "app", "envelopes", "exporting", "fits", "learning", "main", "plans", "scale", "voyages", "watching", "waterways",
]  # fmt: skip
