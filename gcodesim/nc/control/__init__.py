"""Meaning: what a control can be told, whatever the language, and what it then does."""
