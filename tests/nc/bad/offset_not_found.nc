; offset_not_found 2
G59.3
