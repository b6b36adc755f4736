"""User accounts: passwords, tokens, authentication, and what each user has of the quota."""
