; axis_without_motion 2
G53 G31 X5 F100
