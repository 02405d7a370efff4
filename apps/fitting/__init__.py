"""What `eyehand fit` reads, draws, serves and writes."""
