"""Compiled inner loops of the planners in space; import from the modules."""
