"""Models behind the UM-Bridge protocol 1.0: the client's side.

===========  ==========================================================
``client``   requests with limits and further tries, over HTTP
``answers``  what a server answers, as numbers; everything else refused
===========  ==========================================================
"""
