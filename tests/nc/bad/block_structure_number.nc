; block_structure 2
DO4
END4
