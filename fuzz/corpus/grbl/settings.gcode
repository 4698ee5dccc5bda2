$$
?
$100=250.5
G21 (a (nested) comment)
X1 Y2
G1 Z-1 F100 ; cut
G2 X3 Y2 I1
G28
$H
M2
