; offset_not_found 2
G54.1 P7
