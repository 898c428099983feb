; other_language 2
TRAORI
M30
