"""TODO benchmarks/stores."""
