"""Commands for operators of an installation: completion in shells, bundles for support."""
