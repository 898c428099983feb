; cycle_q_not_positive 3 linuxcnc
F100 S1 M3
G83 X1 Z-1 R1 Q0
