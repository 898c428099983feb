; cycle_word_missing 2
G81 X1 R1 F100 S1 M3
