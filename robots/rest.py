"""Earlier import path of the REST client; new programs import it from ``robots.client``."""

from robots.client.rest import Login, RestClient

__all__ = ["Login", "RestClient"]
