"""The physics: scenes become plans, plans become Taichi kernels that advance packs of particles."""
