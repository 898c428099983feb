; unused_word 2
G0 X1e3
