"""Bench of the service: what a user waits for, from the start of a cloud to a robot that drives."""
