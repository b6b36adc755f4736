"""Shared parts of benches: the cloud under test, processes that a bench starts, runs in parallel, and figures."""
