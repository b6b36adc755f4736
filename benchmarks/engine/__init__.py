"""Bench of the engine: containers that start, crash and are many, lost machines, the master, and messages."""
