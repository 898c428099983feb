; stray_percent 2 linuxcnc
%
G0 X1
