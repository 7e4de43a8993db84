"""Sentences of NMEA 0183: checksums first, then the kept parsers; from recordings and from a ship's own network."""
