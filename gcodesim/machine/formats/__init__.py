"""Foreign machine descriptions, turned into machine files."""
