"""Alerts that somebody has acknowledged."""
