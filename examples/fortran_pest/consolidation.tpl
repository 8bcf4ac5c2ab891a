ptf %
HEIGHT OF THE LAYER     4.00
LOAD                    50.0
STIFFNESS               %   E_oed    %
PERMEABILITY            %     k      %
NUMBER OF READINGS      12
1.        3.        7.        14.       30.       60.       90.       120.
180.      240.      365.      540.
