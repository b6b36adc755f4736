"""Stop of a robot: the latch that every velocity of its clone passes."""
