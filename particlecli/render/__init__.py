"""From frames to pictures: camera, light, ground, tone. Never imports the dynamics."""
