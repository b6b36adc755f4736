"""Lifts: the controller that shares them among the robots of a building, and a simulated lift."""
