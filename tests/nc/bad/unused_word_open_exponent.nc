; unused_word_open 2
G0 X1e3
