; modal_conflict 2
G90 G91 G0 X1
