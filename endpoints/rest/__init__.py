"""The REST service: one router a resource, under ``/v1``."""
