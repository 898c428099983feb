; block_structure 3
DO1
DO1
END1
END1
