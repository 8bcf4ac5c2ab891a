"""Hypoplasticity with intergranular strain.

==========  ===========================
``shared``  what hypoplastic laws share
``clay``    hypoplasticity of clay
``sand``    hypoplasticity of sand
==========  ===========================
"""
