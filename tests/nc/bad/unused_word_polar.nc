; unused_word 2
G0 @5
M30
