"""Commands that stop robots and release them."""
