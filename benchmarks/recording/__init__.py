"""Costs of the recording of a robot."""
