"""How long local planners take for a control cycle."""
