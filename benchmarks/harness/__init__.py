"""Shared parts of benches: the cloud under test, processes of a bench, parallel runs, and figures."""
