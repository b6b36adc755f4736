"""Paths on a map file, planned right here, and pictures of paths. Needs ``ppaas[plan]``."""
