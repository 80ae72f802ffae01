"""The rigid body as somebody else's FMU: built from C around MuJoCo's library, for the tests."""
