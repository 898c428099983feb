; modal_conflict 2
G43.1 G92 Z5
