"""What has mass: rigid and flexible bodies, and how they are held together."""
