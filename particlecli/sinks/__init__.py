"""Sinks: what becomes of frames and pictures. They know frames and scenes, never the dynamics."""
