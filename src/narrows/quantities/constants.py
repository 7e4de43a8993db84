"""Constants of nature and of units."""

GRAVITY = 9.81
"""Of the earth [m/s2]."""
KNOT = 1852 / 3600
"""One nautical mile an hour [m/s]."""
AIR_DENSITY = 1.225
"""Mass density of the air at 15 degrees Celsius [kg/m3]."""
