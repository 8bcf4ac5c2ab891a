"""Series from results on meshes, sampled at points inside elements."""
