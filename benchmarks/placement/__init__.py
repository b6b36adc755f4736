"""Benches of placement: a master with real control links, and a comparison of balancers."""
