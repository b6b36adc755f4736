"""Whole robots in a hotel: they drive in the traffic of each floor, wait for lifts, and ride."""
