; cycle_dwell_missing 3
F100 S1 M3
G82 X1 Z-1 R1
G80
M30
