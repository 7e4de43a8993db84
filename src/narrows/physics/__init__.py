"""One phenomenon a file: functions of arithmetic and ``abs()``, so that floats, columns and symbols all pass."""
