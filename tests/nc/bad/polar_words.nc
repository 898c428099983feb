; polar_words 2 linuxcnc
G0 X1 @5
M2
