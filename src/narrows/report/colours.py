"""Colours for the colour-blind, with lines that remain legible in grey."""

# Palette of Okabe and Ito.
BLUE, ORANGE, GREEN, PURPLE, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#6B6B6B"
DASHES = ("-", "--", ":", "-.")
