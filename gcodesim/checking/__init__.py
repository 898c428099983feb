"""The check of one program, from its text to the verdict."""
