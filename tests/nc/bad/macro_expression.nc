; macro_unsupported 2
G0 X[1+2]
