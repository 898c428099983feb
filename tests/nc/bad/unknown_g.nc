; unknown_g 2
G123 X1
