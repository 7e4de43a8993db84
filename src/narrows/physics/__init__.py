"""Physics: one phenomenon a file, in functions of arithmetic and ``abs()`` for floats, arrays and symbols."""
