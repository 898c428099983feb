"""What a user asks to ignore, and what that does to the verdict."""
