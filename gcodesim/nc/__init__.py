"""The NC language: from program text to a canonical program in machine coordinates."""
