"""Traces of requests and goals through the processes of a cloud."""
