"""Interface meshes, normals, segments, mortar operators D and M, gap."""
