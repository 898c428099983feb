; unknown_g 3
G54.2 P1
G0 X1
