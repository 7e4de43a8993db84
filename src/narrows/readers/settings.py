"""Numbers of the readers that one may want to change: unit and reason of each."""

# Cells and sheets
LONGEST_CELL = 60  # characters of a cell in a sentence
LARGEST = 1e20  # beyond it a number stands for a missing one (netCDF fills with 9.97e36) and spoils every sum
SHEET_ROWS = 400  # rows of a sheet among which its header is looked for
DEEPEST = 50  # elements of MATLAB files inside each other
# Text
BLOCK = 1 << 22  # bytes that are looked at together
FULL_SHARE = 0.5  # [1] of its cells that a row has, where it is no line of text above the table
UNIT_SHARE = 0.6  # [1] of the cells under a header that read as units, where they are its units
DIALECT_BYTES = 1 << 18  # by which encoding, separator, decimals and header are found
DIALECT_ROWS = 400  # the same
# NMEA 0183
MOST_SHIPS = 2000  # whose reports are counted; then the half heard least is forgotten
PART_WAIT = 2.0  # [s] for the next part of an AIS message
MOST_OPEN = 256  # messages that wait for parts; then the oldest is given up
SNIFFED = 1 << 16  # bytes of a file by which a recording is recognised
SOURCE_SENTENCES = 20_000  # looked at to choose the talker of each quantity
NMEA_SHARE = 0.5  # [1] of the lines of a recording that are sentences
TALKER_SILENCE = 5.0  # [s] then another talker is used: receivers change their names
