"""The command line: one thin command per verb, related verbs in one file."""

from narrows.cli import envelopes, fits, learning, voyages, watching
from narrows.cli.app import app, main

__all__ = ["app", "envelopes", "fits", "learning", "main", "voyages", "watching"]
