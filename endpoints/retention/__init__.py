"""Retention: what a cloud deletes when it is old enough."""
