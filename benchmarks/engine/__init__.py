"""Bench of the engine: start, crash and number of containers, lost machines, the master, and messages."""
