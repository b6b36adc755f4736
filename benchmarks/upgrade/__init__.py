"""Upgrade of a cloud, one process after another, while robots drive."""
