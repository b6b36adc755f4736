"""Bench of placement: a master with real control links, and balancers side by side."""
