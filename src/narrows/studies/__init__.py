"""Published cases made again, ours beside their own numbers."""
