"""Inputs of the monitor: sentences from the network, a serial line or a recording, second by second."""
