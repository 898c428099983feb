; bad_character 2
G0 X1 $
