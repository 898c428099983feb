; bad_character 2 linuxcnc
G0 X1 / Y2
