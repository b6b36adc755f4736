"""Paths on a map file, planned on this computer without a cloud. Needs ``ppaas[plan]``."""
