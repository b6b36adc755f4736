"""Verbs of commands that are large enough for a module of their own."""
