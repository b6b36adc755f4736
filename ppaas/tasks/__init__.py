"""Tasks that any capable robot of a map may do: who does which, and what becomes of each."""
