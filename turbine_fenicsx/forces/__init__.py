"""Forces, one file each: springs and dampers, gravity, torques, forces on points and surfaces."""
