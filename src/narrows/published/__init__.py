"""Published models, one cited file each."""
