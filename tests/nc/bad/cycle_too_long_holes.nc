; cycle_too_long 3
F100 S1 M3
G81 X1 Z-100 R1 K100001
