"""User accounts: passwords, tokens, authentication, and usage of stored resources."""
