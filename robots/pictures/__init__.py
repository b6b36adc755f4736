"""TODO robots/pictures."""
