; block_structure 2
IF [1 EQ 1]
