; modal_conflict 2 linuxcnc
G43.1 G92 Z5
