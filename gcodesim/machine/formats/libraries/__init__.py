"""Tool libraries of other programs and controls, each read as if it were a tools file."""
