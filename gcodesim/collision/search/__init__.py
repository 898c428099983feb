"""The search over program time: first contact, clearances and contact intervals."""
