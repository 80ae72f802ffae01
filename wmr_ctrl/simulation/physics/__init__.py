"""The robot as a rigid body on tyres, in MuJoCo (extra `physics`): a second plant for any law."""
