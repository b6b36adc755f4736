"""Doors: the controller that opens them for the robots of a building, and a simulated door."""
