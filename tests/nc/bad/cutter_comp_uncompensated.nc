; cutter_comp_uncompensated 3
S1000 M3
G41 D1 G1 X1 F100
M30
