ptf %
stiffness %e-1            % %e-2            %
loads     %load           % %load2          %
