"""What a ship will do beside the banks: as the rudder is, with a pilot who takes over, and hard over either way."""
