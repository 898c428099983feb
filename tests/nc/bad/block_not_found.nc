; block_not_found 3
N5
GOTO 10
