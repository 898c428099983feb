; axis_missing 2
G31
