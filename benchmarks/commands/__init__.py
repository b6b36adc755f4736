"""TODO benchmarks/commands."""
