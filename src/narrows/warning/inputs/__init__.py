"""Inputs of the monitor: sentences and Signal K from the network, a serial line or a recording, second by second."""
