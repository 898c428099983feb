; polar_words 2 linuxcnc
G18 G0 @5 ^9
M2
