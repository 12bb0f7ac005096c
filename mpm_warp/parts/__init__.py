"""Parts of a scene, one file each: declaration, kernel, place in the step (`mpm_warp.scene`)."""
