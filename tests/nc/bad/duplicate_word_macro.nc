; duplicate_word 2
G65 P1 A1 A2
