"""The monitor's page: what is known, in a browser on the bridge; alerts acknowledged there."""
