; same_group_last 2
G0 G1 X5 F100
M30
