"""Services behind the endpoints: stores, accounts, caches and the interface of the engine, made once."""
