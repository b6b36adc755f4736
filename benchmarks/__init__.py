"""Benchmarks of PPaaS, run from a checkout by ``ppaas bench NAME``; the wheel has none of them."""
