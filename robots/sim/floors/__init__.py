"""Simulated buildings: a world for each floor, lifts that carry robots between them, and doors."""
