; comment_nested 2
G0 X1 (a (b) c)
