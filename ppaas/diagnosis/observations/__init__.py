"""Observations of a robot's messages: counts, rates, sizes, stamps and frames."""
