"""Verbs of commands that are large enough for a separate module."""
