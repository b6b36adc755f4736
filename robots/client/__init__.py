"""TODO robots/client."""
