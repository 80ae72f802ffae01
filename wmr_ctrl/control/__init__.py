"""Control: law, guard and map onto the wheels composed into one sampled System."""
