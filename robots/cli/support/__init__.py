"""Commands for whoever operates an installation: completion of words in a shell, bundles for those who help."""
