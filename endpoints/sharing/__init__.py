"""Rights on robots: who may do what, by ownership, shares and scopes of tokens."""
