"""Collision: certified triangle tests, bounding boxes and the first contact along a path."""
