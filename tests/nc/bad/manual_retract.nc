; manual_retract 3
F100 S1 M3
G88 X1 Z-1 R1 P1
G80
M30
