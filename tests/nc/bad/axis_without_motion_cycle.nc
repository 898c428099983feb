; axis_without_motion 4
F100 S1 M3 G0 Z9
G81 X1 Z-1 R1
G53 X5
