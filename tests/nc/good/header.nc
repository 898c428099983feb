%
O0001 (fanuc: a header as posted, messages, ignored blocks, text behind the end)
G0 G17 G40 G49 G80 G90 (G80 leaves the motion code alone)
g 5 5 x 1 . 5 y-.5 z +5.
(MSG, hello) (just a comment) (debug,world) ; and G0 X9
/G0 X2
N999999999 G1 X3 F1000 S500 M3 ; M8
X4 G80
T3
M6
M8
M9
%
G0 X100 and anything at all $$$
