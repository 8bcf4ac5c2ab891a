"""Bodies of requests and answers, as described in OpenAPI.

==================  ================================================================================================
``administration``  models for administrators: API keys, the state of the installation; hooks
``agents``          models of what agents send and are sent
``ags``             models of what is answered about files in the AGS 4 format
``drafts``          models of what is answered about problems in the making: drafts, files of measurements, examples
``mesh``            models of a body: its mesh, what was measured on it, and how it moves
``responses``       lists and small answers of the routes; larger ones are in :mod:`geoswarm.records`
``statistics``      models of what is asked about the statistics of a job; the answers are in
                    :mod:`geoswarm.records.statistics`
==================  ================================================================================================
"""
