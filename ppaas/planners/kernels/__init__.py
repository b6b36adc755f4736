"""Compiled inner loops of the planners; import from the modules."""
