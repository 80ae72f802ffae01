"""The world around a law: references, sensors, disturbances and drives, each a System in a file."""
