; modal_conflict 2 linuxcnc
G90 G91 G0 X1
