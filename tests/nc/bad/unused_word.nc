; unused_word 2 linuxcnc
G0 X1 H2
