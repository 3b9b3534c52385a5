%
(A square with a circle in it, and a line of dots: G-code for `beamtick sim examples/square.nc --machine examples/machine.toml`)
G21 G90 G17 G94
M5 S0
G0 X10 Y10
M4 S600 F3000          ; power follows the speed
G1 X60
Y40
X10
Y10
G0 X45 Y25
G2 I-10 J0 S400        ; a full circle about (35, 25)
G0 X10 Y50
G91                    ; incremental
G1 X10 S800
S0 X5                  ; S0 is dark
S800 X10
S0 X5
S800 X10
G90
M5
G0 X0 Y0
M2
%
