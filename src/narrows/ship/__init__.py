"""The ship, its actuators, its motion, its canal, and the ship file."""
