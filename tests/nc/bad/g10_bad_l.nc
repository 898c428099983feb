; g10_bad_l 2
G10 L3 P1 X1
