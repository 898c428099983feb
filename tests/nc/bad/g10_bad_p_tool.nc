; g10_bad_p 2
G10 L10 R5
