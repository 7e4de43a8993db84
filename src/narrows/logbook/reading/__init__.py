"""A ship's own log in: tables, recordings of NMEA 0183, onto a waterway, in the package's axes."""
