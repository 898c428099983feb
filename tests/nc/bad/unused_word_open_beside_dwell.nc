; unused_word_open 2 (X is the time of G4, so Y belongs to nothing)
G1 G4 X5 Y3 F100
