; axis_without_motion 3
G1 X1 F100
G53 G2 X5 R9
