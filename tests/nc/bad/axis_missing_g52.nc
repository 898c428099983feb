; axis_missing 2
G52
