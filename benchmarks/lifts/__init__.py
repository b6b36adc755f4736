"""Bench of lifts that robots share."""
