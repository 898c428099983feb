; m_per_block_open 2 haas
M3 M8
M30
