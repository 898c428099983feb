; unused_word_open 2 (X belongs to G28, so R belongs to nothing)
G2 X5 G28 R3 F100
