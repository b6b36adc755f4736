"""TODO robots/onboard/executor."""
