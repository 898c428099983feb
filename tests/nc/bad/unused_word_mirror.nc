; unused_word 2
G51.1 X0 A5
