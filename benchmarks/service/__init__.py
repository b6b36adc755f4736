"""TODO benchmarks/service."""
