"""Parts of a scene, one file each: declaration, kernel, place in the plan."""
