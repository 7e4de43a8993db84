"""The monitor: second by second from messages to alerts; a simulated bridge for demonstration."""
