; rotary_in_cycle 3 linuxcnc
F100 S1 M3
G81 X1 A5 Z-1 R1
