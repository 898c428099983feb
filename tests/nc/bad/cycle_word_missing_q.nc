; cycle_word_missing 2 linuxcnc
G83 X1 Z-5 R1 F100 S1 M3
