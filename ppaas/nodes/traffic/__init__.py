"""Grants robots of a map how far they may drive."""
