"""Earlier import path of the REST client, deprecated: import it from ``robots.client``."""

import warnings

from robots.client.rest import Login, RestClient

__all__ = ["Login", "RestClient"]

warnings.warn("robots.rest is deprecated: import from robots.client instead", DeprecationWarning, stacklevel=2)
