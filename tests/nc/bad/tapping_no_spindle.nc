; tapping_no_spindle 3 linuxcnc
F100
G84 X1 Z-1 R1
