; modal_conflict 2
G4 P1 G28 X0
