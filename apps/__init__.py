"""The commands a person runs; the only place where all rooms meet."""
