; unknown_g 3 linuxcnc
M428
G0 X1
