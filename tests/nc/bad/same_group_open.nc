; same_group_open 2 haas
G0 G1 X5 F100
