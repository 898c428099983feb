"""What a pair of bodies does at a single instant."""
