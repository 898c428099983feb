; unused_word_open 2
G1 X1 R5 F100
