; duplicate_word 2 linuxcnc
G0 X1 Y2 X3
