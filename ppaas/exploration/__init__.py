"""Exploration of an unknown place: frontiers of its map, and the choice among them."""
