; block_not_found 2 haas
M97 P5
