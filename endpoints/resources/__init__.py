"""Resources that requests use in common: stores, accounts, caches and the interface of the engine, made once."""
