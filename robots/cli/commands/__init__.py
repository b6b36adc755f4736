"""Commands of the client side, a module for each, named as it is on the command line."""
