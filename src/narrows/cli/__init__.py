"""The command line: one thin command a verb, a file for those that belong together."""

from narrows.cli import envelope, fits, manoeuvre, plans, reproduce, scale, voyages, waterway
from narrows.cli.app import app, main

__all__ = ["app", "envelope", "fits", "main", "manoeuvre", "plans", "reproduce", "scale", "voyages", "waterway"]
