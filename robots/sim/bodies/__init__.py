"""Bodies of simulated people, and furniture."""
