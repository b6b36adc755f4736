"""Bench of buildings: floors, lifts, doors, docks and chargers."""
