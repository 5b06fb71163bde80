"""Draws chains: poses, and movies of motions. For animate() and Environment, and by a link for the tool plot.

body.py: what a scene has to draw, and where it is at given states. poses.py: as lines of a picture. movie.py: as a picture that moves."""
