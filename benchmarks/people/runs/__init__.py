"""Runs of robots and people in a simulated world, scored by its truth."""
