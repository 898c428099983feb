; unknown_g 3
G0 X1
G81 Z-5 R2 F100
