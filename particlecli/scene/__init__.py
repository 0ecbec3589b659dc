"""The scene language: what a user may write, as frozen pydantic models. Never imports Taichi."""
