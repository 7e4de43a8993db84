"""What ends the range in which a ship is safe, in words."""

import math

import xarray as xr

CHOKED, AGROUND, ENGINE = "the canal chokes", "the keel", "the engine"
NONE, RUDDER, UPSET = "no rudder holds it", "the rudder", "what throws it off"
KNOWLEDGE, PILOT, TESTS, RANGE = "what the tests know", "the pilot", "the tests end", "faster was not asked"
# The same in a sentence.
AT_LENGTH = {
    CHOKED: "the choking of the canal",
    AGROUND: "the water under the keel",
    ENGINE: "the engine",
    NONE: "the rudder, of which none is enough",
    RUDDER: "the rudder, whose reserve is used up",
    UPSET: "what throws the ship off, against which even the most likely ship is not held by one who knows it",
    KNOWLEDGE: "what the tests know of the ship (the most likely one would be held)",
    PILOT: "the pilot (one who knew the ship would hold it)",
    TESTS: "the end of the tests",
    RANGE: "what was asked",
}


def cause(here: xr.Dataset, share: float, limit: float) -> str:
    """Say what keeps a ship from being safe at an offset and a speed."""
    # limit [rad]
    if not bool(here["clear"]):
        return _blocked(here)
    if float(here["held"]) >= share:
        return TESTS
    if float(here["known"]) >= share:
        return PILOT
    if float(here["certain"]) >= share:
        return KNOWLEDGE
    rudder = float(here["rudder_likely"])
    return NONE if math.isnan(rudder) else RUDDER if abs(rudder) > limit else UPSET


def _blocked(here: xr.Dataset) -> str:
    if not bool(here.get("driven", True)):
        return ENGINE
    return CHOKED if math.isnan(float(here["clearance"])) else AGROUND
