"""What is wrong with this machine, said before anything is downloaded: run by the Makefile, on Python 3.6 or newer."""

import importlib
import os
import platform
import shutil
import struct
import sys

OLDEST, NEWEST = (3, 11), (3, 15)
"""Of Python, between which narrows is tried."""
NEEDED = 1.5e9
"""Bytes that the environment takes, about."""
PROCESSORS = ("x86_64", "amd64", "arm64", "aarch64")
"""For which the libraries come compiled."""


def dotted(version):
    return ".".join(str(part) for part in version[:2])


def faults(version=None, bits=None, processor=None, free=None, libc=None, lacks=None):
    """Return what hinders the installation, a sentence each; arguments are the machine's own unless they are given."""
    version = tuple(version or sys.version_info)
    bits = bits or 8 * struct.calcsize("P")
    processor = (processor or platform.machine()).lower()
    free = shutil.disk_usage(".").free if free is None else free
    libc = libc or (platform.libc_ver()[0] if sys.platform == "linux" else "any")
    lacks = missing() if lacks is None else lacks
    said = []
    if version < OLDEST:
        needed = f"narrows needs {dotted(OLDEST)} or newer: make PYTHON=python3.12 ..."
        said.append(f"this is Python {dotted(version)} and {needed}")
    if lacks:
        remedy = "install them (on Debian and Ubuntu: apt install python3-venv), or take another, make PYTHON=..."
        said.append(f"this Python has no {' and '.join(lacks)}: {remedy}")
    if bits < 64 or processor not in PROCESSORS:
        said.append(f"the libraries come compiled for 64 bits on x86 and ARM, this is {bits} bits on {processor}")
    if libc not in ("glibc", "any"):
        said.append("the libraries come compiled for glibc, and this system has none (Alpine?): take a Debian image")
    if free < NEEDED:
        said.append(f"{free / 1e9:.1f} GB are free here and the environment takes {NEEDED / 1e9:.1f}: make room")
    if not os.access(".", os.W_OK):
        said.append("this folder cannot be written to: copy it elsewhere")
    return said


def missing():
    """Return which modules of Python's own a system has taken out."""
    lacks = []
    for name in ("venv", "ensurepip"):
        try:
            importlib.import_module(name)
        except ImportError:
            lacks.append(name)
    return lacks


def notes(version=None):
    """Return what may hinder it."""
    version = tuple(version or sys.version_info)
    if version[:2] <= NEWEST:
        return []
    return [f"this is Python {dotted(version)}; narrows is tried up to {dotted(NEWEST)}, and libraries may lack it"]


if __name__ == "__main__":
    for sentence in notes():
        print("narrows: " + sentence)
    hindrances = faults()
    sys.exit("\n".join("narrows: " + sentence for sentence in hindrances) if hindrances else 0)
