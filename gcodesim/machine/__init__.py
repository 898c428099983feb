"""The machine model: links, joints, meshes, tools and the files they come from."""
