"""Controllers: what they measure and command, generator torque, pitch drives, events."""
