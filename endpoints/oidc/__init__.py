"""Login with an identity provider, by OpenID Connect."""
