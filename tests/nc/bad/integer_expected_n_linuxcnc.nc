; integer_expected 2 linuxcnc
N-1 G0 X1
M2
