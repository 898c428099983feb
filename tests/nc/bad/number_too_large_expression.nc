; number_too_large 2
G0 X[1000000*10000000]
