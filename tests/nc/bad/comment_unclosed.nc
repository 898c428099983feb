; comment_unclosed 2
G0 X1 (never closed ; really
