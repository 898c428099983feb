; axis_without_motion 2
G53 X1
