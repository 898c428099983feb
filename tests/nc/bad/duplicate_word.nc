; duplicate_word 2
G0 X1 Y2 X3
