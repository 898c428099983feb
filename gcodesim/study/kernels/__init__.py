"""Device code that only the studies use."""
