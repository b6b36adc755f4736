"""Commands of the client side: they reach a running cloud over REST, from anywhere, with the base install."""
