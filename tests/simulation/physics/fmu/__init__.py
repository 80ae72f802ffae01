"""The rigid body as another author's FMU: built from C around MuJoCo's library, for the tests."""
