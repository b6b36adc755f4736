"""Merging of the maps of robots while they make them."""
