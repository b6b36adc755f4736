"""The demo: a cloud of its own, simulated robots with missions, and a score of how they went."""
