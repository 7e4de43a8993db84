"""One phenomenon a file: functions of arithmetic and ``abs()`` alone, so that floats, columns and symbols all pass."""
