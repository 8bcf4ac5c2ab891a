"""Hypoplasticity of clay and sand.

========================  ========================================================================================
``clay``                  the functions of hypoplasticity of clay
``sand``                  the functions of hypoplasticity of sand
``intergranular_strain``  intergranular strain along a straight path of strain
``step``                  one step of either by substeps
``rate``                  rates of stress and tangent of a hypoplastic law along a straight path of strain, by its
                          functions of invariants
========================  ========================================================================================
"""
