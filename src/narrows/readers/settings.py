"""Settings of the readers, with unit and reason."""

# Cells and sheets
LONGEST_CELL = 60  # characters of a cell in a sentence
LARGEST = 1e20  # a larger number marks a missing one (netCDF fills with 9.97e36) and spoils every sum
SHEET_ROWS = 400  # rows of a sheet that are searched for its header
# Text
FULL_SHARE = 0.5  # [1] least share of filled cells in a row of the table; fewer: text above it
UNIT_SHARE = 0.6  # [1] least share of cells under a header that read as units
DIALECT_BYTES = 1 << 18  # bytes for finding encoding, separator, decimals and header
DIALECT_ROWS = 400  # rows for the same
HEADER_LINES = 20  # most lines over which the cells of a header may go on
# NMEA 0183
MOST_SHIPS = 2000  # ships whose reports are counted; then the half with the fewest is dropped
SNIFFED = 1 << 16  # bytes of a file for recognising a recording
SOURCE_SENTENCES = 20_000  # sentences for choosing the talker of each quantity
NMEA_SHARE = 0.5  # [1] least share of sentences among the lines of a recording
TALKER_SILENCE = 5.0  # [s] silence after which another talker is used: receivers change their names
