"""Disk space of the local stores: measures it, and reserves some for writes that must not fail."""
