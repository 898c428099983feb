; bad_character 2 (U+017F is no S)
ſ100
