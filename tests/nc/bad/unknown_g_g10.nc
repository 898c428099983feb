; unknown_g 2
G10 L2 P1 X1
