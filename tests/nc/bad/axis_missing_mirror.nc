; axis_missing 2
G51.1
