; unknown_word 2
G0 U1
