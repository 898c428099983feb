; expression_unclosed 2
G0 X[1+2
