"""Compiled inner loops of the local planners; import from the modules."""
