; negative_word 2
G4 P-1
