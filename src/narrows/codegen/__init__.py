"""The engine: terms, pose, actuators, section of the water, control law and contact as ONE traced system.

``tape`` writes down what regressors and control laws do; ``free_motion`` solves for the accelerations in symbols;
``step`` writes rates, contact and a whole step as straight ``lines``; ``derivatives`` differentiates them line by line;
``printers`` print them as Python and as loops over lanes, ``kernel`` makes a module of the latter with the bookkeeping
in ``kernels``; ``cache`` keeps all of it on disk, ``run`` lays vessels out, and ``system`` is the door.
"""
