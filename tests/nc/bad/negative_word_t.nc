; negative_word 2
T-1
