"""Stored plans: the stretches that they share, how waypoints are written as bytes, and where plans are looked for."""
