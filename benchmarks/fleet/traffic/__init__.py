"""Simulated robots with real clones, led by the traffic of their map."""
