"""Runs forward calculations in a process that can be killed, with everything that it starts.

====================  ==============================================================================="""
