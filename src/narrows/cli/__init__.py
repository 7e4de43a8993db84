"""The command line: one thin command a verb, a file for those that belong together."""

from narrows.cli import envelopes, fits, learning, models, voyages, watching
from narrows.cli.app import app, main

__all__ = ["app", "envelopes", "fits", "learning", "main", "models", "voyages", "watching"]
