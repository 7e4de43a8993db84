"""The monitor: second by second from what the bridge tells to alerts; a simulated bridge to see it at work."""
