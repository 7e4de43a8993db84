"""NMEA 0183 sentences, from recordings and from a ship's network: checksums first, then established parsers."""
