; unknown_g 3
G43.4 H1
G0 X1
