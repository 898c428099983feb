; unknown_g 2 linuxcnc
G5.1 X10 Y10 I5 J5
