"""Removal of users, robots and maps: nothing of them is left for later ones of the same names."""
