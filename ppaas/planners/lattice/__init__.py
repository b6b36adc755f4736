"""Hybrid A* on a lattice of poses, for robots with a smallest turning radius."""
