"""TODO robots/demo."""
