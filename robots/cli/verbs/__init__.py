"""TODO robots/cli/verbs."""
