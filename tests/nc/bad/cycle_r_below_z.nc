; cycle_r_below_z 3 linuxcnc
F100 S1 M3
G81 X1 Z5 R1
