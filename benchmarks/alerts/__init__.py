"""Alerts of Prometheus for a real cloud: what breaks, when the alert fires, what mends it, and when it resolves."""
