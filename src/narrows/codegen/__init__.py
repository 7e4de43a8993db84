"""The engine: it compiles terms, pose, actuators, water section, control law and contact as ONE traced system.

``trace`` records the operations of regressors and control laws; ``free_motion`` solves for the accelerations
symbolically; ``step`` writes rates, contact and a whole step as straight ``lines``; ``kernel`` differentiates them
line by line; ``printers`` print them in a language, and as loops over lanes beside the bookkeeping of
``kernels``; ``cache`` stores all of it on disk; ``system`` is the public entry.
"""
