"""Captive tests: tables and raw records in, checked columns in SI out."""
