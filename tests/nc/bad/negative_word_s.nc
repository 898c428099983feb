; negative_word 2
S-1
