"""Builder of the documentation site: these pages, with a reference that is made from the code, as HTML."""
