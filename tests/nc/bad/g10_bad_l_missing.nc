; g10_bad_l 2
G10 P1 X1
