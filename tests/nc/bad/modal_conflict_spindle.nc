; modal_conflict 2
M3 M4
