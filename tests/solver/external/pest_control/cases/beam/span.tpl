ptf ~
~ span         ~ ~ PI         ~
