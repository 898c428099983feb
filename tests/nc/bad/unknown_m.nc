; unknown_m 2
M123 P1
G0 X1
M30
