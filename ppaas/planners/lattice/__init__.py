"""Hybrid A* on a lattice of poses, for robots with a minimum turning radius."""
