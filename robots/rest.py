"""Alias of ``robots.client``, for programs that import the REST client by its earlier path."""

from robots.client.rest import Login, RestClient

__all__ = ["Login", "RestClient"]
