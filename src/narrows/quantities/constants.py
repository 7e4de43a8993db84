"""Constants of nature and of units."""

# Of the earth [m/s2].
GRAVITY = 9.81
# One nautical mile an hour [m/s].
KNOT = 1852 / 3600
# Mass density of the air at 15 degrees Celsius [kg/m3].
AIR_DENSITY = 1.225
